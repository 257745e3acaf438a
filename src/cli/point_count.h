#pragma once

#include <cstddef>
#include <string>

namespace pcl_gpu_icp::cli {

/// Points of a PCD or PLY file as its header has them; 0 where it cannot be read or does not say.
std::size_t pointsInHeader(const std::string& path);

} // namespace pcl_gpu_icp::cli
