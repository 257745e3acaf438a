#pragma once

#include <string>

namespace pcl_gpu_icp::view {

/// Text from anywhere as it can be drawn on one line: what is no UTF-8 and control characters become U+FFFD.
std::string lineOf(const std::string& text);

/// The last part of a path, so too.
std::string fileNameOf(const std::string& path);

} // namespace pcl_gpu_icp::view
