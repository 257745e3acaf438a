#pragma once

#include <array>
#include <cstddef>
#include <string>

namespace pcl_gpu_icp::report {

/// printf into a string.
std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

/// "1 iteration", "2 iterations".
std::string counted(std::size_t count, const char* what);

/// "along (0.71, 0.71, 0)".
std::string directionText(const char* how, const std::array<double, 3>& direction);

} // namespace pcl_gpu_icp::report
