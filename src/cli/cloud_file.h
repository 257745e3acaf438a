#pragma once

#include "cli/cloud.h"

#include <optional>
#include <string>

namespace pcl_gpu_icp::cli {

enum class CloudFormat { Pcd, Ply };

/// By the extension, whatever its case.
std::optional<CloudFormat> formatOf(const std::string& path);

/// Reads a PCD or PLY file, told apart by its content.
/// \throws Failure (Input) that names the file and says what is wrong with it
Cloud readCloud(const std::string& path);

/// \throws Failure (Output) where the format cannot hold a field of the cloud
void checkWritable(const Cloud& cloud, CloudFormat format);

/// The content of a file.
std::string writeCloud(const Cloud& cloud, CloudFormat format);

} // namespace pcl_gpu_icp::cli
