#pragma once

#include "pairs.h"

#include <pcl_gpu_icp/points.h>

#include <array>

namespace pcl_gpu_icp::stages {

using Pivot = std::array<double, 3>;

/// Where a cloud lies. What is kept on the device is about the pivot, so that float32 keeps its digits far from the
/// origin.
struct Placement {
  Pivot pivot{};      ///< the median of each coordinate over a few of the points that take part
  float rounding = 0; ///< half a unit in the last place of their largest coordinate, but for points far from all others
};
Placement placementOf(const Points& points);

/// Copies pairs (source[i], target[i]) to the device, about the pivots of p and q. Pairs with a non-finite point are
/// left out.
void packPairs(opencl::Queue& queue,
               const Points& source,
               const Points& target,
               const Placement& p,
               const Placement& q,
               Pairs& pairs);

/// Copies a cloud to the device, about its pivot. Non-finite points keep their place.
void packCloud(opencl::Queue& queue, const Points& points, const Placement& placement, Cloud& cloud);

} // namespace pcl_gpu_icp::stages
