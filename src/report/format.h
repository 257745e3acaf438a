#pragma once

#include <string>

namespace pcl_gpu_icp::report {

/// printf into a string.
std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

} // namespace pcl_gpu_icp::report
