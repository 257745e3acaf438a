#pragma once

#include "cli/cloud_pair.h"

#include "view/pair_view.h"

namespace pcl_gpu_icp::cli {

/// What --report and --png show of a pair.
view::PairView shownPair(const CloudPair& pair, const std::vector<view::NamedPose>& poses);

} // namespace pcl_gpu_icp::cli
