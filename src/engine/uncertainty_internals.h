#pragma once

#include "system_solution.h"

#include <pcl_gpu_icp/uncertainty.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

namespace pcl_gpu_icp {

/// \param spectrum says what is determined: of the system, or of that of the pairs that fit
/// \param sigma standard deviation of a residual
Uncertainty uncertaintyOf(const System& system, const Spectrum& spectrum, double sigma);

/// The motions by how much of what they do to the points the system sees: a value is 1 where it sees all of it.
/// \param points matrix of the same unknowns for point-to-point pairs; where it leaves motions free as spectrumOf()
/// \param noise what of a value is nothing
Spectrum spectrumAgainst(const SquareMatrix<6>& points, const System& system, double noise);

/// The standard deviation of a normally distributed number from the median of its absolute values, so that a minority
/// of others does not count; 0 where there are none. \param residuals infinite where there is none: these are taken
/// out, and the rest is in another order after
double robustDeviation(std::vector<float>& residuals);

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
