#pragma once

#include "cli/cloud.h"

#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// Whether it is the content of a legacy VTK file.
bool isVtk(std::string_view content);

/// Reads the points of a legacy VTK file of the dataset POLYDATA or UNSTRUCTURED_GRID, ascii or binary, float or
/// double. Of what stands behind them nothing is kept.
/// \throws Failure (Input) that names the file and says what is wrong with it
Cloud readVtk(const std::string& path, std::string_view content);

} // namespace pcl_gpu_icp::cli
