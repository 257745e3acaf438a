#pragma once

#include "symmetric_eigen.h"

#include <pcl_gpu_icp/uncertainty.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

namespace pcl_gpu_icp {

/// Some of many values in the order of leaves, where all would take longer and tell no more: runs of neighbours, since
/// the memory of single ones is far apart.
class Sample {
public:
  explicit Sample(std::size_t count)
  : count_(count)
  , each_(count / most + 1)
  {
  }

  /// How many values one of them stands for.
  std::size_t each() const { return each_; }

  /// Calls `use` with the number of each value.
  template <typename Use>
  void forEach(const Use& use) const
  {
    for (std::size_t run = 0; run < count_; run += each_ * run_length)
      for (std::size_t i = run; i < std::min(run + run_length, count_); ++i)
        use(i);
  }

private:
  static constexpr std::size_t most = 1 << 14, run_length = 64;

  std::size_t count_, each_;
};

/// Adds up what the uncertainty of point-to-point pairs takes.
class PointPairs {
public:
  /// \param origin near the points
  /// \param each how many pairs one that is added stands for
  explicit PointPairs(const std::array<double, 3>& origin, std::size_t each = 1)
  : origin_(origin)
  , each_(static_cast<double>(each))
  {
  }

  /// \param p source point at the pose
  void add(const std::array<double, 3>& p, double squared_distance);

  /// The matrix of turns about `centre` and shifts.
  SquareMatrix<6> matrixAbout(const std::array<double, 3>& centre) const;

  /// \param rounding of the points' coordinates
  std::optional<Uncertainty> uncertainty(double rounding) const;

private:
  std::array<double, 3> origin_;
  double each_;
  double count_ = 0;
  std::array<double, 3> sum_{};
  SquareMatrix<3> products_{};
  double squared_distances_ = 0;
};

} // namespace pcl_gpu_icp
