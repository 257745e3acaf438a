#pragma once

#include "cli/compilation_notice.h"
#include "cli/live_line.h"

#include "report/progress.h"

#include <chrono>

namespace pcl_gpu_icp::cli {

/// Shows how far a batch has come: a bar where stderr is a terminal, and a line on stdout for each pair
/// unless that is a terminal with the bar on it.
class BatchProgress {
public:
  /// \param kept have a result already
  BatchProgress(std::size_t pairs, std::size_t kept, std::size_t kept_unsuccessful, bool quiet);

  void add(const report::PairIdentity& identity, const report::PairOutcome& outcome);
  const report::Progress& progress() const { return progress_; }

private:
  using Clock = std::chrono::steady_clock;

  report::Progress progress_;
  LiveLine line_;
  CompilationNotice notice_;
  bool has_lines_;
  Clock::time_point begin_ = Clock::now();
};

} // namespace pcl_gpu_icp::cli
