#pragma once

#include "cli/cloud_pair.h"

#include "report/alignment_report.h"
#include "view/pair_view.h"

namespace pcl_gpu_icp::cli {

/// Where the source lay, where it was put and, where another pose fits as well, that.
std::vector<view::NamedPose> posesOf(const report::AlignmentReport& report, const CloudPair& pair);

/// What --report and --png show of a pair.
/// \param most_points of each cloud; as many as here make a report of 5 MB
view::PairView
shownPair(const CloudPair& pair, const std::vector<view::NamedPose>& poses, std::size_t most_points = 100000);

} // namespace pcl_gpu_icp::cli
