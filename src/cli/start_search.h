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

/// Where an alignment starts, and how that was found.
struct Start {
  CloudPair pair;           ///< with its guess
  AlignmentOptions options; ///< with the loss that goes with it
  std::optional<report::SearchedGuess> searched_guess;
  std::optional<report::FoundOverlap> found_overlap;
};

/// Finds other starts of a pair.
class StartSearch {
public:
  using Progress = std::function<void(std::size_t done, std::size_t all)>;

  /// \param share of a batch that the pair is of; null: none
  /// \param times gets how long searches took, as "guess" and "overlap"
  StartSearch(const Device& device, std::shared_ptr<DeviceShare> share, StageTimes& times, Progress progress = {});

  /// What PoseSearch finds. None where a cloud has too few points or nothing fits.
  std::optional<Start> fromAnywhere(const Start& start) const;

  /// What OverlapSearch makes of the guess, and with it a loss of one spacing unless one was given. None where a cloud
  /// has too few points.
  std::optional<Start> fromOverlap(const Start& start) const;

private:
  template <typename Search>
  Search searchOf(const AlignmentOptions& options) const;

  Device device_;
  std::shared_ptr<DeviceShare> share_;
  StageTimes& times_;
  Progress progress_;
};

} // namespace pcl_gpu_icp::cli
