#pragma once

#include "cli/cloud.h"

#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// Reads a scan as KITTI has it: x, y, z and intensity of each point, four little-endian floats and nothing else.
/// \throws Failure (Input) that names the file, where it can be no such scan
Cloud readKittiScan(const std::string& path, std::string_view content);

} // namespace pcl_gpu_icp::cli
