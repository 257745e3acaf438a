#pragma once

#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// What a file that is neither PCD nor PLY looks like, and the command that makes it one.
std::string describeForeign(const std::string& path, std::string_view content);

} // namespace pcl_gpu_icp::cli
