#pragma once

#include "cli/cloud_pair.h"
#include "cli/options.h"

#include "report/alignment_report.h"

#include <pcl_gpu_icp/device.h>

#include <cstddef>
#include <functional>
#include <optional>

namespace pcl_gpu_icp::cli {

/// With --guess auto: puts the pose that PoseSearch finds in the place of the pair's guess.
/// \param lanes of the search; 0: as many as a batch
/// \return what it came to; none where no search was asked for
/// \throws Failure (Input) where a cloud has too few points
std::optional<report::SearchedGuess> searchGuess(CloudPair& pair,
                                                 const AlignmentOptions& options,
                                                 const Device& device,
                                                 unsigned lanes,
                                                 std::function<void(std::size_t done, std::size_t all)> progress = {});

} // namespace pcl_gpu_icp::cli
