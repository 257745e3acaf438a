#pragma once

#include "cli/cloud.h"

#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// Reads the vertices of a PLY file, ascii or binary, under the names PCL gives them: nx is normal_x, and red, green,
/// blue (and alpha) in bytes are one field rgb (rgba). The other elements and the comments are kept as they are, and
/// the pose that PCL's element camera has is the cloud's. Lists of the vertices are skipped. Stricter than
/// pcl::PLYReader, which needs the colours in one order and trusts the header's sizes.
/// \throws Failure (Input) that names the file and says what is wrong with it
Cloud readPly(const std::string& path, std::string_view content);

/// An organised cloud has its size in obj_info lines, as PCL reads it, and a pose of the sensor is PCL's element
/// camera. Padding is not in it. \throws Failure (Output) where PLY has no type for a field
std::string plyHeader(const Cloud& cloud);

/// The content of a binary PLY file.
std::string writePly(const Cloud& cloud);

} // namespace pcl_gpu_icp::cli
