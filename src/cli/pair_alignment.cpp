#include "cli/pair_alignment.h"

#include "cli/failure.h"
#include "cli/guess.h"

#include "report/degrees.h"
#include "report/difference.h"
#include "report/ending.h"
#include "report/judgement.h"

#include <algorithm>
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

/// By how much the pose puts the source elsewhere than another, in radii of the larger cloud.
double distanceBetween(const RigidTransform& pose,
                       const RigidTransform& other,
                       const report::AlignmentReport& report,
                       const CloudPair& pair)
{
  const double radius = std::max(pair.source->extent, pair.target->extent) / 2;
  const report::Difference difference = report::differenceOf(pose, other, report.centroid);
  return difference.metres / radius + difference.degrees * report::radians_per_degree;
}

/// Whether it ended so far from the guess that this tells nothing of whether another pose fits as well.
bool isFar(const report::AlignmentReport& report, const RigidTransform& guess, const CloudPair& pair)
{
  constexpr double far = 0.8; // 45 degrees
  return distanceBetween(report.transform, guess, report, pair) > far;
}

/// Enters what a search found. The rival is a pose that it held against the one where the alignment ended.
void enter(report::SearchedGuess searched, report::AlignmentReport& report, const CloudPair& pair)
{
  const auto away = [&](const report::FoundPose& pose) {
    return distanceBetween(pose.transform, report.transform, report, pair);
  };
  if (searched.rival && away(*searched.rival) < away(searched.found))
    std::swap(searched.found, *searched.rival);
  constexpr double elsewhere = 0.35; // 20 degrees
  if (!searched.rival && away(searched.found) > elsewhere)
    searched.rival = searched.found;
  report.searched_guess = searched;
}

report::AlignmentReport reportOf(const Start& start, const BatchResult& result)
{
  report::AlignmentReport report;
  report.source = start.options.source;
  report.target = start.options.target;
  report.found_overlap = start.found_overlap;
  report.result = result.alignment;
  report.fitness_score = result.fitness_score;
  describe(report, start.options, start.pair, result.transform);
  if (start.searched_guess)
    enter(*start.searched_guess, report, start.pair);
  return report;
}

/// What ICP comes to from one start after another.
class Attempts {
public:
  Attempts(const RunIcp& run, const CloudPair& pair)
  : run_(run)
  , pair_(pair)
  {
  }

  void add(const std::optional<Start>& start)
  {
    if (!start)
      return;
    if (start->searched_guess)
      searched_guess_ = start->searched_guess;
    IcpRun run = run_(start->pair, start->options);
    report::AlignmentReport report = reportOf(*start, run.result);
    tried_.push_back(
        {report.searched_guess.has_value(), report.found_overlap.has_value(), judgementOf(report).verdict});
    if (!best_)
      at_guess_ = report.result;
    else if (!isBetter(report, best_->report))
      return;
    best_ = {std::move(report), std::move(run.errors)};
    pose_ = run.result.transform;
    taken_ = tried_.size() - 1;
  }

  bool areSettled() const { return isSettled(best_->report); }

  /// Whether no pose near the guess is known to be the one.
  bool leavePoseOpen() const
  {
    const report::AlignmentReport& report = best_->report;
    return endingOf(report) != report::Ending::TooCoarse &&
           ((tried_.front().verdict == Verdict::Wrong && !areSettled()) ||
            isFar(report, pair_.inFileCoordinates(pair_.guess), pair_));
  }

  const RigidTransform& pose() const { return pose_; }

  PairAlignment best() &&
  {
    if (searched_guess_)
      enter(*searched_guess_, best_->report, pair_);
    tried_[taken_].verdict = judgementOf(best_->report).verdict;
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
  const CloudPair& pair_;
  std::vector<report::TriedStart> tried_;
  std::size_t taken_ = 0;
  std::optional<PairAlignment> best_;
  RigidTransform pose_;      ///< of the best, between the prepared clouds
  AlignmentResult at_guess_; ///< of the first: "before" is where its start was, wherever the best one started
  std::optional<report::SearchedGuess> searched_guess_; ///< held against the best, whatever that began from
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
  Attempts attempts(run, pair);
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
  if (!options.guess && attempts.leavePoseOpen()) {
    Start from = start;
    from.pair.guess = attempts.pose();
    const std::optional<Start> found = search.fromAnywhere(from);
    attempts.add(found);
    if (found && !attempts.areSettled())
      attempts.add(search.fromOverlap(*found));
  }
  return std::move(attempts).best();
}

} // namespace pcl_gpu_icp::cli
