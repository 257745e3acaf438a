#pragma once

#include <pcl_gpu_icp/motions.h>

#include <array>
#include <vector>

namespace pcl_gpu_icp {

/// The identity, and turns that leave no rotation far from all.
std::vector<std::array<double, 9>> turnsOf(Motions motions);

} // namespace pcl_gpu_icp
