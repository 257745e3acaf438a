#pragma once

#include "cli/cloud.h"

#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// Reads the content of a PCD file: ascii, binary or binary_compressed. Stricter than pcl::PCDReader, which reads
/// numbers it cannot parse as zeros and trusts the header's sizes.
/// \throws Failure (Input) that names the file and says what is wrong with it
Cloud readPcd(const std::string& path, std::string_view content);

/// The content of a binary_compressed PCD file.
std::string writePcd(const Cloud& cloud);

} // namespace pcl_gpu_icp::cli
