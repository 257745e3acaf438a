#include "cli/pair_alignment.h"

#include "cli/failure.h"
#include "cli/guess.h"

#include "report/degrees.h"
#include "report/ending.h"
#include "report/judgement.h"

#include <cmath>
#include <utility>
#include <vector>

namespace pcl_gpu_icp::cli {
namespace {

/// Unless any is given, converged is what moves the points by less than a thousandth of their spacing.
AlignmentOptions withEpsilons(const AlignmentOptions& options, const CloudPair& pair)
{
  constexpr double hardly = 1e-3;
  AlignmentOptions result = options;
  const double step = hardly * pair.target->spacing(), radius = pair.source->extent / 2;
  if (options.translation_epsilon || options.rotation_epsilon || !(step > 0 && radius > 0))
    return result;
  result.translation_epsilon = step;
  result.rotation_epsilon = step / radius * report::degrees_per_radian;
  return result;
}

/// Whether no other start could come to more.
bool isSettled(const report::AlignmentReport& report)
{
  return endingOf(report) == report::Ending::TooCoarse || judgementOf(report).verdict == Verdict::Good ||
         isDoubtedForRivalAlone(report);
}

bool isBetter(const report::AlignmentReport& report, const report::AlignmentReport& other)
{
  const auto rank = [](const report::AlignmentReport& of) {
    const double fit = of.result.quality ? fitOf(*of.result.quality) : 0;
    return std::pair(-static_cast<int>(judgementOf(of).verdict), fit);
  };
  // What the pairs do not determine is said, and not where noise puts it from another start.
  if (endingOf(other) == report::Ending::Undetermined && judgementOf(report).verdict != Verdict::Good)
    return false;
  return rank(report) > rank(other);
}

report::AlignmentReport reportOf(const Start& start, const BatchResult& result)
{
  report::AlignmentReport report;
  report.source = start.options.source;
  report.target = start.options.target;
  report.searched_guess = start.searched_guess;
  report.found_overlap = start.found_overlap;
  report.result = result.alignment;
  report.fitness_score = result.fitness_score;
  describe(report, start.options, start.pair, result.transform);
  return report;
}

/// What ICP comes to from one start after another.
class Attempts {
public:
  explicit Attempts(const RunIcp& run)
  : run_(run)
  {
  }

  void add(const std::optional<Start>& start)
  {
    if (!start)
      return;
    IcpRun run = run_(start->pair, start->options);
    report::AlignmentReport report = reportOf(*start, run.result);
    tried_.push_back(
        {report.searched_guess.has_value(), report.found_overlap.has_value(), judgementOf(report).verdict});
    if (!best_)
      at_guess_ = report.result;
    else if (!isBetter(report, best_->report))
      return;
    best_ = {std::move(report), std::move(run.errors)};
    taken_ = tried_.size() - 1;
  }

  bool areSettled() const { return isSettled(best_->report); }
  bool beganWrong() const { return tried_.front().verdict == Verdict::Wrong; }

  PairAlignment best() &&
  {
    tried_[taken_].taken = true;
    AlignmentResult& result = best_->report.result;
    if (at_guess_.inliers > 0)
      result.rmse_before = at_guess_.rmse_before;
    if (at_guess_.quality && result.quality)
      result.quality->before = at_guess_.quality->before;
    best_->report.tried = std::move(tried_);
    return std::move(*best_);
  }

private:
  const RunIcp& run_;
  std::vector<report::TriedStart> tried_;
  std::optional<PairAlignment> best_;
  AlignmentResult at_guess_; ///< of the first: "before" is where its start was, wherever the best one started
  std::size_t taken_ = 0;
};

std::optional<Start> required(std::optional<Start> found, const AlignmentOptions& options, const char* why_not)
{
  if (!found)
    throw Failure(ExitCode::Input, options.source + " onto " + options.target + ": " + why_not);
  return found;
}

} // namespace

PairAlignment
alignPair(const CloudPair& pair, const AlignmentOptions& options, const StartSearch& search, const RunIcp& run)
{
  Start start{pair, withEpsilons(options, pair), std::nullopt, std::nullopt};
  if (options.guess && asksForSearch(*options.guess))
    start = *required(search.fromAnywhere(start),
                      options,
                      "--guess auto found no pose: it takes clouds of one size, of at least 10 points that are not all "
                      "at one place");
  Attempts attempts(run);
  if (options.finds_overlap)
    attempts.add(required(search.fromOverlap(start),
                          options,
                          "--overlap auto takes clouds of at least 10 points that are not all at one place"));
  else
    attempts.add(start);
  if (options.once)
    return std::move(attempts).best();

  if (!options.finds_overlap && !attempts.areSettled())
    attempts.add(search.fromOverlap(start));
  if (!options.guess && attempts.beganWrong() && !attempts.areSettled()) {
    const std::optional<Start> found = search.fromAnywhere(start);
    attempts.add(found);
    if (found && !attempts.areSettled())
      attempts.add(search.fromOverlap(*found));
  }
  return std::move(attempts).best();
}

} // namespace pcl_gpu_icp::cli
