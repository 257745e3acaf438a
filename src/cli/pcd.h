#pragma once

#include "cli/cloud.h"

#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// Reads the content of a PCD file: ascii, binary or binary_compressed. Stricter than pcl::PCDReader, which reads
/// numbers it cannot parse as zeros and trusts the header's sizes. Sizes that the header does not give are the data's.
/// \throws Failure (Input) that names the file and says what is wrong with it
Cloud readPcd(const std::string& path, std::string_view content);

/// The content of a PCD file with all fields and comments: binary_compressed, or binary where fields are padding. The
/// cloud's other elements are not in it.
std::string writePcd(const Cloud& cloud);

} // namespace pcl_gpu_icp::cli
