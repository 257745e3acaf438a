#pragma once

#include <array>

namespace pcl_gpu_icp {

/// The axis times the angle, of less than half a turn.
std::array<double, 3> rotationVector(const std::array<double, 9>& rotation);

/// Rodrigues' formula.
std::array<double, 9> rotationBy(const std::array<double, 3>& vector);

} // namespace pcl_gpu_icp
