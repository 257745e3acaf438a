#pragma once

#include "cli/cloud.h"

#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// Whether it is the content of a LAS file, or of a LAZ file, which begins as one.
bool isLas(std::string_view content);

/// Reads a LAS file (ASPRS 1.0 to 1.4, point formats 0 to 10): x, y and z as double, intensity, and classification.
/// Nothing else is kept.
/// \throws Failure (Input) that names the file and says what is wrong with it; of a LAZ file what decompresses it
Cloud readLas(const std::string& path, std::string_view content);

} // namespace pcl_gpu_icp::cli
