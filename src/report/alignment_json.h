#pragma once

#include "report/alignment_report.h"
#include "report/json.h"

namespace pcl_gpu_icp::report {

/// As docs/align.schema.json describes.
Json alignmentJson(const AlignmentReport& report);

} // namespace pcl_gpu_icp::report
