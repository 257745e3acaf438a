#pragma once

#include "report/json.h"

#include <pcl_gpu_icp/uncertainty.h>

#include <string>

namespace pcl_gpu_icp::report {

/// A line for each turn and shift: its standard deviation, in degrees or the files' unit, or that it is not determined.
std::string uncertaintyText(const Uncertainty& uncertainty);

/// The motions that are not determined, such as "along (1, 0, 0), about (0, 0, 1)".
std::string undeterminedMotions(const Uncertainty& uncertainty);

/// As docs/align.schema.json describes.
Json uncertaintyJson(const Uncertainty& uncertainty);

} // namespace pcl_gpu_icp::report
