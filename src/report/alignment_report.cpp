#include "report/alignment_report.h"

#include "report/alignment_times.h"
#include "report/ending.h"
#include "report/format.h"
#include "report/judgement.h"
#include "report/matrix.h"
#include "report/uncertainty_report.h"

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
  return format("guess      the best of %zu starts, score %.2g of 1", guess.starts, guess.score) +
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

const char* improvement(const AlignmentReport& report)
{
  const double change = changeOfDistance(report);
  return change == 0 ? "unchanged" : change < 0 ? "improved" : "got worse";
}

} // namespace

std::string nameOf(const TriedStart& start)
{
  if (!start.overlap)
    return start.searched ? "a search" : "the guess";
  return std::string(start.searched ? "a search and " : "") + "what they have in common";
}

std::string toText(const AlignmentReport& report)
{
  const AlignmentResult& result = report.result;
  std::string text = cloudText("source", report.source, report.source_points);
  text += cloudText("target", report.target, report.target_points);
  text += "verdict    " + judgementText(judgementOf(report)) + "\n";
  for (const std::string& advice : adviceFor(report))
    text += "try        " + advice + "\n";
  text += "result     " + endingText(report) + "\n";
  if (report.tried.size() > 1)
    text += triedText(report.tried);
  text += "device     " + result.device.name + " (" + toString(result.device.type) + ", " + result.device.platform +
          ", driver " + result.device.driver + ")\n";
  text += std::string("metric     ") + toString(result.metric) + lossText(result);
  text += result.motions == Motions::Rigid ? "\n" : std::string(", motions ") + toString(result.motions) + "\n";
  text += format("search     %s, %u threads; pipeline %s, %s precision\n",
                 toString(result.search),
                 result.threads,
                 toString(result.pipeline),
                 toString(result.precision));
  if (report.searched_guess)
    text += guessText(*report.searched_guess);
  if (report.found_overlap)
    text += format("overlap    %.0f %% of the source, by the best of %zu ways from coarse to fine\n",
                   100 * report.found_overlap->share,
                   report.found_overlap->ways);
  if (!result.searched.empty())
    text += format("searched   %zu points in the first iteration, %zu in the last\n",
                   result.searched.front(),
                   result.searched.back());
  text +=
      result.inliers > 0
          ? format("RMSE       %.6g before, %.6g after (%s)\n", result.rmse_before, result.rmse, improvement(report))
          : std::string("RMSE       undefined\n");
  if (result.quality)
    text += qualityText(*result.quality);
  text += format("inliers    %zu\n", result.inliers);
  text += report.fitness_score
              ? format("fitness    %.6g (mean squared distance to the nearest target point)\n", *report.fitness_score)
              : std::string("fitness    undefined\n");
  text += std::string("degenerate ") + degeneracyText(result) + "\n";
  if (result.uncertainty)
    text += uncertaintyText(*result.uncertainty);
  text += "transform\n" + matrixText(report.transform);
  text += "times\n";
  for (const auto& [what, milliseconds] : timesOf(report))
    text += format("  %-22s %10.1f ms\n", what.c_str(), milliseconds);
  return text;
}

} // namespace pcl_gpu_icp::report
