#pragma once

#include "report/alignment_report.h"
#include "view/pair_view.h"

#include <string>

namespace pcl_gpu_icp::view {

/// An alignment at a glance, as a PNG file: its verdict, the clouds before and after from three sides, how far the
/// source is from the target.
std::string pictureOf(const report::AlignmentReport& report, const PairView& view);

} // namespace pcl_gpu_icp::view
