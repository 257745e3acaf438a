#include "report/alignment_report.h"

#include "report/alignment_times.h"
#include "report/ending.h"
#include "report/format.h"
#include "report/judgement.h"
#include "report/matrix.h"
#include "report/uncertainty_report.h"

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp::report {
namespace {

std::string cloudText(const char* role, const std::string& file, const PointCounts& points)
{
  std::string dropped;
  const auto add = [&dropped](std::size_t count, const char* why) {
    if (count > 0)
      dropped += (dropped.empty() ? "" : ", ") + std::to_string(count) + " " + why;
  };
  add(points.non_finite, "not finite");
  add(points.too_large, "beyond 1e18");
  add(points.zero_returns, "zero returns");
  add(points.downsampled, "merged by the voxel grid");
  add(points.coincident, "coincident with another");
  std::string text = format("%-11s", role) + file;
  text += format(": %zu points, %zu used", points.in_file, points.used);
  return text + (dropped.empty() ? "\n" : " (dropped: " + dropped + ")\n");
}

std::string lossText(const AlignmentResult& result)
{
  if (!result.loss.weighs())
    return "";
  std::string text = std::string(", loss ") + toString(result.loss.function);
  if (result.loss_scale > 0)
    text += format(":%.6g", result.loss_scale) + (result.loss.scale > 0 ? "" : " (from the residuals)");
  return text;
}

std::string guessText(const SearchedGuess& guess)
{
  return format("guess      of %zu starts anywhere the best has score %.2g of 1", guess.starts, guess.score) +
         (guess.next_score ? format("; the next best that is elsewhere %.2g\n", *guess.next_score) : "\n");
}

std::string triedText(const std::vector<TriedStart>& tried)
{
  std::string text;
  for (const TriedStart& start : tried)
    text += std::string(text.empty() ? "tried      " : "           ") + "from " + nameOf(start) + ": " +
            toString(start.verdict) + (start.taken ? ", taken\n" : "\n");
  return text;
}

std::string verdictText(const Judgement& judgement, bool coloured)
{
  std::string text = judgementText(judgement);
  const std::string word = toString(judgement.verdict);
  constexpr int colours[] = {32, 33, 31}; // ANSI's green, yellow, red
  if (!coloured)
    return text;
  return format("\033[1;%dm", colours[static_cast<int>(judgement.verdict)]) + word + "\033[0m" +
         text.substr(word.size());
}

/// What has no partner may end farther away at a good pose.
std::string improvement(const AlignmentReport& report)
{
  const double change = changeOfDistance(report);
  if (change > 0 && judgementOf(report).verdict == Verdict::Good)
    return "";
  return std::string(" (") + (change == 0 ? "unchanged" : change < 0 ? "improved" : "got worse") + ")";
}

std::string pairsText(const AlignmentReport& report)
{
  const AlignmentResult& result = report.result;
  const double share =
      static_cast<double>(result.inliers) / static_cast<double>(std::max<std::size_t>(1, result.source_points));
  std::string text =
      result.inliers > 0
          ? format(
                "RMSE       %.6g before, %.6g after%s\n", result.rmse_before, result.rmse, improvement(report).c_str())
          : std::string("RMSE       undefined\n");
  text += format("pairs      %zu, %.0f %% of the source's points\n", result.inliers, 100 * share);
  if (!report.fitness_score)
    return text + "fitness    undefined\n";
  return text + format("fitness    %.6g (mean squared distance to the nearest target point), its root %.6g\n",
                       *report.fitness_score,
                       std::sqrt(*report.fitness_score));
}

} // namespace

std::string nameOf(const TriedStart& start)
{
  if (!start.overlap)
    return start.searched ? "a search" : "the guess";
  return std::string(start.searched ? "a search and " : "") + "what they have in common";
}

std::string toText(const AlignmentReport& report, const TextStyle& style)
{
  const AlignmentResult& result = report.result;
  const Judgement judgement = judgementOf(report);
  std::string text = "verdict    " + verdictText(judgement, style.coloured) + "\n";
  for (const std::string& advice : adviceFor(report))
    text += "try        " + advice + "\n";
  text += "result     " + endingText(report) + "\n";
  if (report.tried.size() > 1)
    text += triedText(report.tried);
  text += "motion     " + motionText(report.transform, report.centroid) + "\n" + matrixText(report.transform);
  text += pairsText(report);
  if (result.quality)
    text += qualityText(*result.quality);
  text += std::string("degenerate ") + degeneracyText(result) + "\n";
  if (result.uncertainty)
    text += uncertaintyText(*result.uncertainty);
  text += cloudText("source", report.source, report.source_points);
  text += cloudText("target", report.target, report.target_points);
  text += std::string("metric     ") + toString(result.metric) + lossText(result);
  text += result.motions == Motions::Rigid ? "\n" : std::string(", motions ") + toString(result.motions) + "\n";
  if (report.searched_guess)
    text += guessText(*report.searched_guess);
  if (report.found_overlap)
    text += format("overlap    %.0f %% of the source, by the best of %s from coarse to fine\n",
                   100 * report.found_overlap->share,
                   counted(report.found_overlap->ways, "way").c_str());
  text += format("search     %s, %u threads; pipeline %s, %s precision\n",
                 toString(result.search),
                 result.threads,
                 toString(result.pipeline),
                 toString(result.precision));
  if (!result.searched.empty())
    text += format("searched   %zu points in the first iteration, %zu in the last\n",
                   result.searched.front(),
                   result.searched.back());
  text += "device     " + result.device.name + " (" + toString(result.device.type) + ", " + result.device.platform +
          ", driver " + result.device.driver + ")\n";
  return text + "times      " + (style.verbose ? nestedTimesText(report) : timesText(report));
}

} // namespace pcl_gpu_icp::report
