#pragma once

#include "cli/cloud_pair.h"

#include "view/pair_view.h"

namespace pcl_gpu_icp::cli {

/// What --report and --png show of a pair.
/// \param start where the source lay, between the prepared clouds
/// \param transform where it was put, in the coordinates of the files
view::PairView shownPair(const CloudPair& pair, const RigidTransform& start, const RigidTransform& transform);

} // namespace pcl_gpu_icp::cli
