#include "report/alignment_json.h"

#include "report/alignment_times.h"
#include "report/ending.h"
#include "report/judgement.h"
#include "report/matrix.h"
#include "report/uncertainty_report.h"

namespace pcl_gpu_icp::report {
namespace {

Json droppedJson(const PointCounts& points)
{
  return {{"non_finite", points.non_finite + points.too_large},
          {"zero_returns", points.zero_returns},
          {"downsampled", points.downsampled},
          {"coincident", points.coincident}};
}

Json lossJson(const AlignmentResult& result)
{
  if (!result.loss.weighs())
    return {};
  return {{"function", toString(result.loss.function)},
          {"scale", result.loss_scale > 0 ? Json(result.loss_scale) : Json()},
          {"given", result.loss.scale > 0}};
}

Json guessJson(const AlignmentReport& report)
{
  if (!report.searched_guess)
    return {};
  const SearchedGuess& guess = *report.searched_guess;
  Json rival;
  if (guess.rival)
    rival = {{"transform", matrixJson(guess.rival->transform)}, {"near", guess.rival->near}};
  return {{"starts", guess.starts},
          {"score", guess.score},
          {"next_score", guess.next_score ? Json(*guess.next_score) : Json()},
          {"rival", rival}};
}

Json triedJson(const std::vector<TriedStart>& tried)
{
  Json json = Json::array();
  for (const TriedStart& start : tried)
    json.push_back({{"from", nameOf(start)}, {"verdict", toString(start.verdict)}, {"taken", start.taken}});
  return json;
}

} // namespace

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
  json["loss"] = lossJson(result);
  json["motions"] = toString(result.motions);
  json["guess"] = matrixJson(report.guess);
  json["searched_guess"] = guessJson(report);
  json["overlap"] = nullptr;
  if (const auto& overlap = report.found_overlap)
    json["overlap"] = {{"share", overlap->share}, {"ways", overlap->ways}};
  json["tried"] = triedJson(report.tried);
  json["search"] = toString(result.search);
  json["threads"] = result.threads;
  json["pipeline"] = toString(result.pipeline);
  json["precision"] = toString(result.precision);
  json["device_bytes"] = result.device_bytes;
  json["transform"] = matrixJson(report.transform);
  const Ending ending = endingOf(report);
  json["converged"] = isAnswer(ending);
  const Judgement judgement = judgementOf(report);
  json["verdict"] = toString(judgement.verdict);
  json["reasons"] = judgement.reasons;
  json["advice"] = adviceFor(report);
  json["quality"] = result.quality ? qualityJson(*result.quality) : Json();
  json["ending"] = toString(ending);
  json["why"] = isAnswer(ending) ? Json() : Json(endingText(report));
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
  json["uncertainty"] = result.uncertainty ? uncertaintyJson(*result.uncertainty) : Json();
  json["warnings"] = report.warnings;
  for (const auto& [what, milliseconds] : timesOf(report))
    json["times_ms"][what] = milliseconds;
  return json;
}

std::string toJson(const AlignmentReport& report)
{
  Json json = documentOf(report.arguments);
  json.update(alignmentJson(report));
  return dump(json);
}

} // namespace pcl_gpu_icp::report
