#include "report/alignment_report.h"

#include "report/alignment_json.h"
#include "report/format.h"
#include "report/matrix.h"
#include "report/verdict.h"

#include <utility>
#include <vector>

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

const char* improvement(const AlignmentReport& report)
{
  const double change = changeOfDistance(report);
  return change == 0 ? "unchanged" : change < 0 ? "improved" : "got worse";
}

using Times = std::vector<std::pair<std::string, double>>;

/// Host and device times under one roof, in the order in which the time passes: "total" of the engine is "align", the
/// device's entries carry a prefix.
Times allTimes(const AlignmentReport& report)
{
  Times times;
  const auto add = [&times](const StageTimes& from, const char* what, const char* as) {
    const auto found = from.find(what);
    if (found != from.end())
      times.emplace_back(as, found->second.milliseconds);
  };
  add(report.command_times, "read", "read");
  add(report.command_times, "device", "device");
  for (const char* step : {"start", "tree", "normals", "pack", "search", "estimate"})
    add(report.result.host_times, step, step);
  for (const auto& [what, time] : report.result.device_times)
    times.emplace_back("device_" + what, time.milliseconds);
  add(report.result.host_times, "total", "align");
  add(report.command_times, "fitness", "fitness");
  add(report.command_times, "total", "total");
  return times;
}

Json droppedJson(const PointCounts& points)
{
  return {{"non_finite", points.non_finite + points.too_large},
          {"zero_returns", points.zero_returns},
          {"downsampled", points.downsampled},
          {"coincident", points.coincident}};
}

} // namespace

std::string toText(const AlignmentReport& report)
{
  const AlignmentResult& result = report.result;
  std::string text = cloudText("source", report.source, report.source_points);
  text += cloudText("target", report.target, report.target_points);
  text += "device     " + result.device.name + " (" + toString(result.device.type) + ", " + result.device.platform +
          ", driver " + result.device.driver + ")\n";
  text += std::string("metric     ") + toString(result.metric) + "\n";
  text += format("search     %s, %u threads; pipeline %s, %s precision\n",
                 toString(result.search),
                 result.threads,
                 toString(result.pipeline),
                 toString(result.precision));
  if (!result.searched.empty())
    text += format("searched   %zu points in the first iteration, %zu in the last\n",
                   result.searched.front(),
                   result.searched.back());
  text += "result     " + verdictText(report) + "\n";
  text +=
      result.inliers > 0
          ? format("RMSE       %.6g before, %.6g after (%s)\n", result.rmse_before, result.rmse, improvement(report))
          : std::string("RMSE       undefined\n");
  text += format("inliers    %zu\n", result.inliers);
  text += report.fitness_score
              ? format("fitness    %.6g (mean squared distance to the nearest target point)\n", *report.fitness_score)
              : std::string("fitness    undefined\n");
  text += std::string("degenerate ") + degeneracyText(result) + "\n";
  text += "transform\n" + matrixText(report.transform);
  text += "times\n";
  for (const auto& [what, milliseconds] : allTimes(report))
    text += format("  %-22s %10.1f ms\n", what.c_str(), milliseconds);
  return text;
}

Json alignmentJson(const AlignmentReport& report)
{
  const AlignmentResult& result = report.result;
  Json json;
  json["source"] = report.source;
  json["target"] = report.target;
  json["points"] = {
      {"source", report.source_points.used},
      {"target", report.target_points.used},
      {"dropped", {{"source", droppedJson(report.source_points)}, {"target", droppedJson(report.target_points)}}}};
  json["device"] = deviceJson(result.device);
  json["metric"] = toString(result.metric);
  json["search"] = toString(result.search);
  json["pipeline"] = toString(result.pipeline);
  json["device_bytes"] = result.device_bytes;
  json["transform"] = matrixJson(report.transform);
  const Verdict verdict = verdictOf(report);
  json["converged"] = isAnswer(verdict);
  json["verdict"] = toString(verdict);
  json["why"] = isAnswer(verdict) ? Json() : Json(verdictText(report));
  json["reason"] = toString(result.reason);
  json["iterations"] = result.iterations;
  json["searched"] = result.searched;
  json["inliers"] = result.inliers;
  json["rmse"] = result.inliers > 0 ? Json(result.rmse) : Json();
  json["rmse_before"] = result.inliers > 0 ? Json(result.rmse_before) : Json();
  json["truncated_rmse"] = result.inliers > 0 ? Json(result.truncated_rmse) : Json();
  json["truncated_rmse_before"] = result.inliers > 0 ? Json(result.truncated_rmse_before) : Json();
  json["fitness_score"] = report.fitness_score ? Json(*report.fitness_score) : Json();
  json["nearest_distance"] = report.nearest_distance ? Json(*report.nearest_distance) : Json();
  json["degenerate"] = toString(degeneracyOf(result));
  json["free_motions"] = result.free_motions;
  json["warnings"] = report.warnings;
  for (const auto& [what, milliseconds] : allTimes(report))
    json["times_ms"][what] = milliseconds;
  return json;
}

std::string toJson(const AlignmentReport& report) { return dump(alignmentJson(report)); }

} // namespace pcl_gpu_icp::report
