#pragma once

#include <pcl_gpu_icp/points.h>

#include <array>
#include <limits>
#include <vector>

namespace pcl_gpu_icp::search {

/// A few of the points that take part, spread over the cloud.
std::vector<const float*> samplesOf(const Points& points);

/// Where the bulk of a cloud lies, so that a few points far from all others decide nothing for the rest: within a
/// thousand times the range of the middle half of the points from their median. All of them where more than half of the
/// points are at one place.
class Bulk {
public:
  explicit Bulk(const std::vector<const float*>& samples);
  explicit Bulk(const Points& points)
  : Bulk(samplesOf(points))
  {
  }

  /// Of each coordinate; 0 without points.
  const std::array<double, 3>& median() const { return median_; }

  /// Whether a point takes part and belongs to the bulk.
  bool holds(const float* xyz) const;

  /// The largest absolute coordinates of those points that it holds, plus an offset.
  std::array<double, 3> largest(const Points& points, const std::array<double, 3>& offset = {}) const;

private:
  std::array<double, 3> median_{};
  double reach_ = std::numeric_limits<double>::infinity();
};

} // namespace pcl_gpu_icp::search
