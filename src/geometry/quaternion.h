#pragma once

#include <array>

namespace pcl_gpu_icp {

/// \param quaternion w x y z, of length 1
std::array<double, 9> rotationOf(const std::array<double, 4>& quaternion);

} // namespace pcl_gpu_icp
