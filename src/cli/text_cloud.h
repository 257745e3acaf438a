#pragma once

#include "cli/cloud.h"

#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// Reads points from the lines of a text, as .xyz, .txt, .csv, .asc and .pts files have them: columns between blanks,
/// tabs, commas or semicolons. Behind comments (#, //) and a count of the points, as .pts has it, a line may name the
/// columns, in any case; it may be a comment too (CloudCompare's //X Y Z). Without one x, y and z are the first three,
/// which is warned of where there are more. Of the other columns nothing is kept. Coordinates are float, or double
/// where the cloud is so far from the origin that float would lose digits of it.
/// \throws Failure (Input) that names the file and the line
Cloud readTextCloud(const std::string& path, std::string_view content);

} // namespace pcl_gpu_icp::cli
