#include "report/comparison_json.h"

namespace pcl_gpu_icp::report {
namespace {

Json optionalJson(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json runJson(const Run& run)
{
  return {{"converged", run.converged},
          {"reason", toString(run.reason)},
          {"iterations", run.iterations},
          {"time_ms", run.time_ms},
          {"rmse", optionalJson(run.rmse)},
          {"fitness_score", optionalJson(run.fitness_score)},
          {"transform", matrixJson(run.transform)}};
}

Json differenceJson(const Difference& difference)
{
  return {{"degrees", difference.degrees}, {"metres", difference.metres}};
}

} // namespace

Json comparisonJson(const ComparisonReport& report)
{
  Json json = documentOf(report.arguments);
  json["source"] = report.source;
  json["target"] = report.target;
  json["points"] = {{"source", report.source_points}, {"target", report.target_points}};
  json["device"] = deviceJson(report.device);
  json["metric"] = toString(report.metric);
  json["pipeline"] = toString(report.pipeline);
  json["stock"] = report.stock ? runJson(*report.stock) : Json();
  json["stock_failure"] = report.stock ? Json() : Json(report.stock_failure);
  json["plugin"] = runJson(report.plugin);
  json["plugin"]["verdict"] = toString(report.judgement.verdict);
  json["plugin"]["reasons"] = report.judgement.reasons;
  json["plugin"]["start_ms"] = report.plugin_start_ms;
  json["speedup"] = report.stock ? Json(report.stock->time_ms / report.plugin.time_ms) : Json();
  json["centroid"] = report.centroid;
  json["difference"] = report.stock ? differenceJson(*report.difference()) : Json();
  json["tolerance"] = differenceJson(report.tolerance);
  json["agree"] = report.agree();
  return json;
}

std::string toJson(const ComparisonReport& report) { return dump(comparisonJson(report)); }

} // namespace pcl_gpu_icp::report
