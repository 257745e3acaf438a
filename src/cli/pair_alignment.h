#pragma once

#include "cli/cloud_pair.h"
#include "cli/options.h"
#include "cli/start_search.h"

#include "report/alignment_report.h"

#include <pcl_gpu_icp/batch.h>

#include <functional>
#include <vector>

namespace pcl_gpu_icp::cli {

struct IcpRun {
  BatchResult result;
  std::vector<double> errors; ///< root mean square distance of the pairs, by iteration
};

/// Runs ICP of a pair once, from its guess.
using RunIcp = std::function<IcpRun(const CloudPair& pair, const AlignmentOptions& options)>;

struct PairAlignment {
  report::AlignmentReport report;
  std::vector<double> errors; ///< of the run that was taken, by iteration
};

/// Aligns a pair: from where the options say; but for --once, where that comes to no good pose, from what the clouds
/// have in common; and where no guess is given and that leaves it wrong, or far from where it began, from anywhere. The
/// best is taken; another pose that fits, if the search found one, is held against it.
///
/// \throws Failure (Input) where a search that was asked for finds no start, and what run throws
PairAlignment
alignPair(const CloudPair& pair, const AlignmentOptions& options, const StartSearch& search, const RunIcp& run);

} // namespace pcl_gpu_icp::cli
