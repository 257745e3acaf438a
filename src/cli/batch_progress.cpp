#include "cli/batch_progress.h"

#include "cli/output_file.h"

#include <unistd.h>

namespace pcl_gpu_icp::cli {

BatchProgress::BatchProgress(std::size_t pairs, std::size_t kept, std::size_t kept_unsuccessful, bool quiet)
: progress_{pairs, kept, kept_unsuccessful}
, line_(!quiet)
, notice_(line_, !quiet)
, has_lines_(!quiet && !(line_.isShown() && isatty(STDOUT_FILENO)))
{
  line_.show(report::barText(progress_));
}

void BatchProgress::add(const report::PairIdentity& identity, const report::PairOutcome& outcome)
{
  ++progress_.done;
  ++progress_.aligned;
  progress_.unsuccessful += outcome.status != report::PairStatus::Converged;
  progress_.seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
  if (has_lines_) {
    line_.clear(); // stdout may lead to the same terminal, e.g. through tee
    writeToStandardOutput(report::lineText(progress_, identity, outcome));
  }
  line_.show(report::barText(progress_));
}

} // namespace pcl_gpu_icp::cli
