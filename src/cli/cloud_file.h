#pragma once

#include "cli/cloud.h"

#include <optional>
#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

enum class CloudFormat { Pcd, Ply };

/// Of a file to write, by the extension, whatever its case.
std::optional<CloudFormat> formatOf(const std::string& path);

/// Reads a PCD, PLY, LAS or VTK file, or a text whose lines are points, told apart by content, or a scan of KITTI,
/// whose name ends in .bin. \throws Failure (Input) that names the file and says what is wrong with it
Cloud readCloud(const std::string& path);

/// Reads the cloud that an argument names: such a file, or for "-" standard input.
/// \throws Failure (Input)
Cloud readCloudArgument(const std::string& argument);

/// Reads the content of such a file.
/// \throws Failure (Input), of a file of another format with what it looks like and what makes it a cloud
Cloud parseCloud(const std::string& path, std::string_view content);

/// \return what of the cloud the format of that file cannot hold
/// \throws Failure (Output) where that is a field
Warnings checkWritable(const Cloud& cloud, const std::string& path);

/// The content of a file.
std::string writeCloud(const Cloud& cloud, CloudFormat format);

} // namespace pcl_gpu_icp::cli
