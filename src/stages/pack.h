#pragma once

#include "pairs.h"

#include <pcl_gpu_icp/points.h>

#include <array>

namespace pcl_gpu_icp::stages {

using Pivot = std::array<double, 3>;

/// A place among the points: the median of each coordinate over a few of the finite ones. What is kept on the device
/// is about the pivot, so that float32 keeps its digits far from the origin.
Pivot pivotOf(const Points& points);

/// Copies pairs (source[i], target[i]) to the device, about the pivots. Pairs with a non-finite point are left out.
void packPairs(opencl::Queue& queue,
               const Points& source,
               const Points& target,
               const Pivot& source_pivot,
               const Pivot& target_pivot,
               Pairs& pairs);

/// Copies a cloud to the device, about the pivot. Non-finite points keep their place.
/// \return the largest absolute coordinate among the finite ones
float packCloud(opencl::Queue& queue, const Points& points, const Pivot& pivot, Cloud& cloud);

/// Variance that rounding to float32 gives coordinates of these sizes.
float resolutionSquared(float largest_source_coordinate, float largest_target_coordinate);

} // namespace pcl_gpu_icp::stages
