#pragma once

#include "report/alignment_report.h"
#include "report/json.h"

namespace pcl_gpu_icp::report {

/// As docs/align.schema.json describes, without what is of the process and not of the pair: version and arguments.
Json alignmentJson(const AlignmentReport& report);

} // namespace pcl_gpu_icp::report
