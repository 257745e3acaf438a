#pragma once

#include "cli/listed_pair.h"

#include "report/alignment_report.h"

#include <pcl_gpu_icp/batch.h>

#include <optional>

namespace pcl_gpu_icp::cli {

/// A pair of a batch on its way.
class PairTask {
public:
  explicit PairTask(const ListedPair& pair)
  : pair_(&pair)
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
  /// Frees what is not needed once that is written.
  void clear()
  {
    report_.reset();
    failure_.reset();
  }

private:
  BatchResult align(DeviceLane& lane);

  const ListedPair* pair_;
  std::optional<report::AlignmentReport> report_;
  std::optional<report::PairFailure> failure_;
};

} // namespace pcl_gpu_icp::cli
