#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// What a file looks like that is of a format that is not read, and the command that makes a cloud of it. Nothing of a
/// text that may be points.
std::optional<std::string> describeForeign(const std::string& path, std::string_view content);

} // namespace pcl_gpu_icp::cli
