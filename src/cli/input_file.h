#pragma once

#include "cli/failure.h"

#include <string>

namespace pcl_gpu_icp::cli {

/// A Failure (Input) that names the file.
Failure inputFailure(const std::string& path, const std::string& why);

/// The content of a regular file.
/// \throws Failure (Input)
std::string readFile(const std::string& path);

} // namespace pcl_gpu_icp::cli
