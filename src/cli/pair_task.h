#pragma once

#include "cli/cloud_pair.h"
#include "cli/listed_pair.h"

#include "report/alignment_report.h"
#include "view/batch_gallery.h"

#include <pcl_gpu_icp/batch.h>
#include <pcl_gpu_icp/search/shared_cache.h>

#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace pcl_gpu_icp::cli {

/// What is made of a file, and how: the file, whether zero returns are dropped, the edge of the voxels.
using PreparedFile = std::tuple<std::string, std::optional<bool>, std::optional<double>>;
/// The clouds of the pairs that are aligned: a file that several need at a time is read once.
using PreparedClouds = search::SharedCache<PreparedCloud, PreparedFile>;

/// A pair of a batch on its way.
class PairTask {
public:
  /// \param clouds of all pairs
  /// \param shown_points of each cloud, to show; 0: nothing will be shown
  PairTask(const ListedPair& pair, PreparedClouds& clouds, std::size_t shown_points)
  : pair_(&pair)
  , clouds_(&clouds)
  , shown_points_(shown_points)
  {
  }

  /// Reads the files and aligns them.
  BatchResult run(DeviceLane& lane);

  const ListedPair& pair() const { return *pair_; }

  /// Whether run() was called and not cancelled.
  bool isDone() const { return report_ || failure_; }
  report::PairOutcome outcome() const { return report_ ? outcomeOf(*report_) : outcomeOf(*failure_); }
  std::string line() const
  {
    return report_ ? resultLine(pair_->identity, *report_) : resultLine(pair_->identity, *failure_);
  }
  /// What is to be shown of it; none of what failed. Once.
  std::optional<view::BatchGallery::Entry> takeShown() { return std::exchange(shown_, std::nullopt); }
  /// Frees what is not needed once that is written.
  void clear()
  {
    report_.reset();
    failure_.reset();
  }

private:
  BatchResult align(DeviceLane& lane);
  CloudPair read();

  const ListedPair* pair_;
  PreparedClouds* clouds_;
  std::optional<report::AlignmentReport> report_;
  std::optional<report::PairFailure> failure_;
  std::size_t shown_points_;
  std::optional<view::BatchGallery::Entry> shown_;
};

} // namespace pcl_gpu_icp::cli
