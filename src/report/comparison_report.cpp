#include "report/comparison_report.h"

#include "report/format.h"
#include "report/json.h"

#include <cmath>

namespace pcl_gpu_icp::report {
namespace {

constexpr double degrees_per_radian = 57.295779513082320877;

std::string optionalText(const std::optional<double>& value) { return value ? format("%.9g", *value) : "undefined"; }

std::string row(const char* what, const std::string& stock, const std::string& plugin)
{
  return format("%-11s %22s %22s\n", what, stock.c_str(), plugin.c_str());
}

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

Difference differenceOf(const RigidTransform& a, const RigidTransform& b, const std::array<double, 3>& centroid)
{
  // |A - B|_F = 2 sqrt(2) sin(angle / 2) keeps its digits at small angles, where the trace loses them.
  double squared = 0;
  for (int i = 0; i < 9; ++i)
    squared += (a.rotation[i] - b.rotation[i]) * (a.rotation[i] - b.rotation[i]);
  const auto image_a = a(centroid[0], centroid[1], centroid[2]);
  const auto image_b = b(centroid[0], centroid[1], centroid[2]);
  return {2 * std::asin(std::fmin(1.0, std::sqrt(squared / 8))) * degrees_per_radian,
          std::hypot(image_a[0] - image_b[0], image_a[1] - image_b[1], image_a[2] - image_b[2])};
}

std::string toText(const ComparisonReport& report)
{
  const Run& stock = report.stock;
  const Run& plugin = report.plugin;
  std::string text = "source      " + report.source + format(": %zu points used\n", report.source_points);
  text += "target      " + report.target + format(": %zu points used\n", report.target_points);
  text +=
      "device      " + report.device.name + " (" + toString(report.device.type) + ", " + report.device.platform + ")\n";
  text += std::string("metric      ") + toString(report.metric) + "\n";
  text += row("", "pcl", "pcl_gpu_icp");
  text += row("time", format("%.1f ms", stock.time_ms), format("%.1f ms", plugin.time_ms));
  text += row("iterations", std::to_string(stock.iterations), std::to_string(plugin.iterations));
  text += row("reason", toString(stock.reason), toString(plugin.reason));
  text += row("RMSE", optionalText(stock.rmse), optionalText(plugin.rmse));
  text += row("fitness", optionalText(stock.fitness_score), optionalText(plugin.fitness_score));
  text += format("speed       %.2fx, or %.2fx without the device's start (%.1f ms)\n",
                 stock.time_ms / plugin.time_ms,
                 stock.time_ms / (plugin.time_ms - report.plugin_start_ms),
                 report.plugin_start_ms);
  text += format("difference  %.3g degrees, %.3g m at the source's centroid (%.6g, %.6g, %.6g): %s %g degrees, %g m\n",
                 report.difference.degrees,
                 report.difference.metres,
                 report.centroid[0],
                 report.centroid[1],
                 report.centroid[2],
                 report.agree() ? "within" : "more than",
                 report.tolerance.degrees,
                 report.tolerance.metres);
  return text;
}

std::string toJson(const ComparisonReport& report)
{
  Json json;
  json["source"] = report.source;
  json["target"] = report.target;
  json["points"] = {{"source", report.source_points}, {"target", report.target_points}};
  json["device"] = deviceJson(report.device);
  json["metric"] = toString(report.metric);
  json["pipeline"] = toString(report.pipeline);
  json["stock"] = runJson(report.stock);
  json["plugin"] = runJson(report.plugin);
  json["plugin"]["start_ms"] = report.plugin_start_ms;
  json["speedup"] = report.stock.time_ms / report.plugin.time_ms;
  json["centroid"] = report.centroid;
  json["difference"] = differenceJson(report.difference);
  json["tolerance"] = differenceJson(report.tolerance);
  json["agree"] = report.agree();
  return dump(json);
}

} // namespace pcl_gpu_icp::report
