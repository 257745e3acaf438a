#pragma once

#include "cli/options.h"
#include "cli/pair_options.h"

#include "report/pair_result.h"

namespace pcl_gpu_icp::cli {

/// One alignment of a batch.
struct ListedPair {
  report::PairIdentity identity;
  AlignmentOptions alignment; ///< its files as they are found from here
};

} // namespace pcl_gpu_icp::cli
