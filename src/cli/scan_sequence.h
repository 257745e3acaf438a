#pragma once

#include "cli/listed_pair.h"

#include <string>
#include <vector>

namespace pcl_gpu_icp::cli {

/// The pairs of consecutive scans, each onto the one before, of the files that a pattern with wildcards matches. Their
/// numbers count: scan_2 is before scan_10.
/// \throws Failure (Input) where it matches fewer than two
std::vector<ListedPair> listSequence(const std::string& pattern, const OptionTexts& options);

} // namespace pcl_gpu_icp::cli
