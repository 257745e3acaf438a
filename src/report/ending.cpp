#include "report/ending.h"

#include "report/format.h"
#include "report/judgement.h"
#include "report/uncertainty_report.h"

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp::report {
namespace {

constexpr std::size_t fewest_pairs = 3; // PCL's minimum, and what determines a pose
// A voxel as large as the cloud, cut by the planes x = 0, y = 0 and z = 0 that the grid has.
constexpr std::size_t voxels_of_one = 8;

bool isTooCoarse(const PointCounts& points) { return points.downsampled > points.used && points.used <= voxels_of_one; }

std::string howItEnded(const AlignmentReport& report)
{
  const AlignmentResult& result = report.result;
  const std::string iterations = counted(static_cast<std::size_t>(result.iterations), "iteration");
  switch (result.reason) {
  case Reason::Iterations:
    return result.iterations < report.iteration_limit ? "stopped after " + iterations + ", which repeat themselves"
                                                      : "stopped at the limit of " + iterations;
  case Reason::Transform:
    return "converged after " + iterations + ": the last one moved by less than the epsilons";
  case Reason::AbsoluteMse:
    return "converged after " + iterations + ": the mean squared distance no longer changes";
  case Reason::RelativeMse:
    return "converged after " + iterations + ": the mean squared distance changes by less than the epsilon";
  default:
    return toString(result.reason) + (" after " + iterations);
  }
}

/// Of three to six.
const char* countWord(int count)
{
  constexpr const char* words[] = {"three", "four", "five", "six"};
  return words[count - 3];
}

std::string tooFewPairsText(const AlignmentReport& report)
{
  const std::size_t pairs = report.result.inliers;
  std::string text = pairs == 0 ? "no pair" : counted(pairs, "pair");
  if (report.max_distance)
    text += format(" within --max-distance %g", *report.max_distance);
  if (pairs > 0)
    text += format(", where %zu are needed", fewest_pairs);
  if (report.nearest_distance)
    text += format("; the nearest source point is %.6g from the target", *report.nearest_distance);
  return text;
}

std::string slidingText(const AlignmentResult& result)
{
  const auto allowed = unknownsOf(result.motions);
  std::string text = format("of the %s motions %d only slide along the surface",
                            countWord(static_cast<int>(std::count(allowed.begin(), allowed.end(), true))),
                            result.free_motions);
  // Where the last step left out more than that, which rounding hides, they are not named.
  if (result.uncertainty && result.uncertainty->free_motions == result.free_motions)
    text += ": " + undeterminedMotions(*result.uncertainty);
  return text;
}

std::string tooCoarseText(const AlignmentReport& report)
{
  const bool source = isTooCoarse(report.source_points);
  const PointCounts& points = source ? report.source_points : report.target_points;
  return format("--leaf left %zu of the %zu points of the %s, as a single voxel might",
                points.used,
                points.in_file,
                source ? "source" : "target");
}

} // namespace

std::string undeterminedText(const AlignmentResult& result)
{
  if (result.inliers > 0 && result.inliers < fewest_pairs)
    return counted(result.inliers, "matched point") + format(", where %zu are needed", fewest_pairs);
  switch (degeneracyOf(result)) {
  case Degeneracy::None:
    return "nothing";
  case Degeneracy::Sliding:
    return slidingText(result);
  case Degeneracy::Line:
    return "all matched points lie on one line, so the rotation about it is not determined";
  case Degeneracy::Point:
    return "all matched points are at one place, so the rotation is not determined";
  case Degeneracy::Empty:
    return "no points were matched, so nothing is determined";
  }
  return "unknown";
}

const char* toString(Ending ending)
{
  switch (ending) {
  case Ending::Converged:
    return "converged";
  case Ending::AtLimit:
    return "at the limit";
  case Ending::GotWorse:
    return "got worse";
  case Ending::Undetermined:
    return "undetermined";
  case Ending::Wrong:
    return "wrong";
  case Ending::Doubtful:
    return "doubtful";
  case Ending::TooCoarse:
    return "too coarse";
  case Ending::TooFewPairs:
    return "too few pairs";
  }
  return "unknown";
}

Ending endingOf(const AlignmentReport& report)
{
  const AlignmentResult& result = report.result;
  if (!result.converged) // an error has been thrown by then
    return Ending::TooFewPairs;
  if (isTooCoarse(report.source_points) || isTooCoarse(report.target_points))
    return Ending::TooCoarse;
  if (degeneracyOf(result) != Degeneracy::None && !report.takes_undetermined)
    return Ending::Undetermined;
  const Verdict verdict = judgementOfPose(report).verdict;
  const bool at_limit = result.reason == Reason::Iterations;
  // A metric of surfaces, or a loss, gives up some of the points' nearness for surfaces that lie on each other.
  const bool surfaces_lie_well = liesWell(report) && result.quality->surfaces;
  if (at_limit && changeOfDistance(report) > 0 && !surfaces_lie_well)
    return Ending::GotWorse;
  if (verdict == Verdict::Wrong)
    return Ending::Wrong;
  if (verdict == Verdict::Doubtful && report.only_good)
    return Ending::Doubtful;
  return at_limit ? Ending::AtLimit : Ending::Converged;
}

double changeOfDistance(const AlignmentReport& report)
{
  // Where one point is far from all others it makes up the whole of it, and its rounding the change.
  constexpr double of_one_point = 1e-6;
  const double before = report.result.truncated_rmse_before;
  const double change = report.result.truncated_rmse - before;
  return std::abs(change) <= std::max(report.resolution, of_one_point * before) ? 0 : change;
}

Degeneracy degeneracyOf(const AlignmentResult& result)
{
  constexpr Degeneracy of_few[fewest_pairs] = {Degeneracy::Empty, Degeneracy::Point, Degeneracy::Line};
  return result.inliers < fewest_pairs ? of_few[result.inliers] : result.degeneracy;
}

std::string degeneracyText(const AlignmentResult& result)
{
  return degeneracyOf(result) == Degeneracy::None ? "no" : "yes: " + undeterminedText(result);
}

std::string plainEndingText(const AlignmentReport& report)
{
  switch (endingOf(report)) {
  case Ending::Converged:
    return howItEnded(report);
  case Ending::AtLimit:
    return howItEnded(report) + ", before it converged";
  case Ending::GotWorse:
    return howItEnded(report) + format(", farther from the target than at the guess: RMSE %.6g before, %.6g after",
                                       report.result.truncated_rmse_before,
                                       report.result.truncated_rmse);
  case Ending::Undetermined:
    return "the pose is not determined: " + undeterminedText(report.result);
  case Ending::Wrong:
  case Ending::Doubtful:
    return howItEnded(report) + "; the pose is " + judgementText(judgementOfPose(report));
  case Ending::TooCoarse:
    return tooCoarseText(report);
  case Ending::TooFewPairs:
    return tooFewPairsText(report);
  }
  return "unknown";
}

std::string endingText(const AlignmentReport& report)
{
  return (isAnswer(endingOf(report)) ? "" : "no answer: ") + plainEndingText(report);
}

} // namespace pcl_gpu_icp::report
