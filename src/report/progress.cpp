#include "report/progress.h"

#include "report/format.h"
#include "report/judgement.h"

#include <cmath>

namespace pcl_gpu_icp::report {
namespace {

constexpr std::size_t bar_width = 24;

std::string durationText(double seconds)
{
  const auto whole = static_cast<unsigned long>(std::lround(seconds));
  const unsigned long hours = whole / 3600, minutes = whole / 60 % 60;
  return hours > 0 ? format("%lu:%02lu:%02lu", hours, minutes, whole % 60) : format("%lu:%02lu", minutes, whole % 60);
}

std::string ofAll(const Progress& progress) { return format("%zu/%zu", progress.done, progress.pairs); }

} // namespace

std::string barText(const Progress& progress)
{
  const std::size_t filled = progress.pairs > 0 ? bar_width * progress.done / progress.pairs : bar_width;
  std::string text = "[" + std::string(filled, '#') + std::string(bar_width - filled, '.') + "] " + ofAll(progress);
  if (progress.unsuccessful > 0)
    text += format(", %zu without success", progress.unsuccessful);
  if (progress.aligned > 0 && progress.seconds > 0) {
    const double rate = static_cast<double>(progress.aligned) / progress.seconds;
    text += format(", %.1f pairs/s, ", rate) +
            durationText(static_cast<double>(progress.pairs - progress.done) / rate) + " left";
  }
  return text;
}

std::string outcomeText(const PairOutcome& outcome)
{
  switch (outcome.status) {
  case PairStatus::Converged:
  case PairStatus::AtLimit:
    return std::string(toString(outcome.status)) + ", " +
           counted(static_cast<std::size_t>(outcome.iterations), "iteration") +
           (outcome.rmse ? format(", RMSE %.6g", *outcome.rmse) : "") +
           (outcome.judgement.verdict == Verdict::Good ? "" : ", " + judgementText(outcome.judgement));
  case PairStatus::NotConverged:
    return outcome.why;
  case PairStatus::Failed:
    return "failed: " + outcome.why;
  }
  return "unknown";
}

std::string lineText(const Progress& progress, const PairIdentity& identity, const PairOutcome& outcome)
{
  return ofAll(progress) + format(" pair %zu ", identity.pair) + identity.source + " onto " + identity.target + ": " +
         outcomeText(outcome) + "\n";
}

} // namespace pcl_gpu_icp::report
