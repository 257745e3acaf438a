#pragma once

#include "cli/cloud_pair.h"
#include "cli/options.h"

#include "report/alignment_report.h"

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/device_share.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

namespace pcl_gpu_icp::cli {

/// With --guess auto: puts the pose that PoseSearch finds in the place of the pair's guess.
/// \param share of a batch that the pair is of; null: none
/// \param times gets how long it took, as "guess"
/// \return what it came to; none where no search was asked for
/// \throws Failure (Input) where a cloud has too few points or nothing fits
std::optional<report::SearchedGuess> searchGuess(CloudPair& pair,
                                                 const AlignmentOptions& options,
                                                 const Device& device,
                                                 std::shared_ptr<DeviceShare> share,
                                                 StageTimes& times,
                                                 std::function<void(std::size_t done, std::size_t all)> progress = {});

/// With --overlap auto: puts what OverlapSearch makes of the pair's guess in its place, and a loss of one spacing into
/// the options that have none.
/// \param share, times as above; the time is "overlap"
/// \return what it came to; none where it was not asked for
/// \throws Failure (Input) where a cloud has too few points
std::optional<report::FoundOverlap> findOverlap(CloudPair& pair,
                                                AlignmentOptions& options,
                                                const Device& device,
                                                std::shared_ptr<DeviceShare> share,
                                                StageTimes& times);

} // namespace pcl_gpu_icp::cli
