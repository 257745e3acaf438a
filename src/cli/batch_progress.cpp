#include "cli/batch_progress.h"

#include "cli/output_file.h"

namespace pcl_gpu_icp::cli {

BatchProgress::BatchProgress(std::size_t pairs, std::size_t kept, std::size_t kept_unsuccessful, bool quiet)
: progress_{pairs, kept, kept_unsuccessful}
, line_(!quiet)
, quiet_(quiet)
{
  line_.show(report::barText(progress_));
}

void BatchProgress::add(const report::PairIdentity& identity, const report::PairOutcome& outcome)
{
  ++progress_.done;
  ++progress_.aligned;
  progress_.unsuccessful += outcome.status != report::PairStatus::Converged;
  progress_.seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
  if (line_.isShown())
    line_.show(report::barText(progress_));
  else if (!quiet_)
    writeToStandardOutput(report::lineText(progress_, identity, outcome));
}

} // namespace pcl_gpu_icp::cli
