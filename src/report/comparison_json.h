#pragma once

#include "report/comparison_report.h"
#include "report/json.h"

namespace pcl_gpu_icp::report {

/// What `compare --json` writes.
Json comparisonJson(const ComparisonReport& report);

} // namespace pcl_gpu_icp::report
