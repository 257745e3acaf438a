#pragma once

#include <pcl_gpu_icp/points.h>

#include <array>
#include <vector>

namespace pcl_gpu_icp {

/// Around points, but for a few far from all others.
struct Box {
  explicit Box(const std::vector<PlacedPoint>& points);

  double thickness() const;

  /// Whether a point is in it or within the margin.
  bool holds(const std::array<double, 3>& point, double margin) const;

  std::array<double, 3> low{}, high{};
};

} // namespace pcl_gpu_icp
