#include "report/comparison_report.h"

#include "report/format.h"
#include "report/judgement.h"

namespace pcl_gpu_icp::report {
namespace {

std::string optionalText(const std::optional<double>& value) { return value ? format("%.9g", *value) : "undefined"; }

std::string row(const char* what, const std::string& stock, const std::string& plugin)
{
  return format("%-11s %22s %22s\n", what, stock.c_str(), plugin.c_str());
}

} // namespace

std::optional<Difference> ComparisonReport::difference() const
{
  return stock ? std::optional(differenceOf(stock->transform, plugin.transform, centroid)) : std::nullopt;
}

bool ComparisonReport::agree() const
{
  const auto found = difference();
  return found && found->degrees <= tolerance.degrees && found->metres <= tolerance.metres;
}

std::string stockText(const ComparisonReport& report)
{
  return std::string("stock: ") +
         (report.stock ? toString(report.stock->reason) : "no answer: " + report.stock_failure);
}

std::string toText(const ComparisonReport& report)
{
  const Run& plugin = report.plugin;
  std::string text = "source      " + report.source + format(": %zu points used\n", report.source_points);
  text += "target      " + report.target + format(": %zu points used\n", report.target_points);
  text +=
      "device      " + report.device.name + " (" + toString(report.device.type) + ", " + report.device.platform + ")\n";
  text += std::string("metric      ") + toString(report.metric) + "\n";
  const auto of_stock = [&report](const auto& describe) {
    return report.stock ? describe(*report.stock) : "no answer";
  };
  const auto timeText = [](const Run& run) { return format("%.1f ms", run.time_ms); };
  const auto iterationsText = [](const Run& run) { return std::to_string(run.iterations); };
  const auto reasonText = [](const Run& run) { return std::string(toString(run.reason)); };
  const auto rmseText = [](const Run& run) { return optionalText(run.rmse); };
  const auto fitnessText = [](const Run& run) { return optionalText(run.fitness_score); };
  text += row("", "pcl", "pcl_gpu_icp");
  text += row("time", of_stock(timeText), timeText(plugin));
  text += row("iterations", of_stock(iterationsText), iterationsText(plugin));
  text += row("reason", of_stock(reasonText), reasonText(plugin));
  text += row("RMSE", of_stock(rmseText), rmseText(plugin));
  text += row("fitness", of_stock(fitnessText), fitnessText(plugin));
  text += "verdict     of pcl_gpu_icp's: " + judgementText(report.judgement) + "\n";
  if (!report.stock)
    return text + stockText(report) + "\n";
  const double stock_ms = report.stock->time_ms;
  text += format("speed       %.2fx, or %.2fx without the device's start (%.1f ms)\n",
                 stock_ms / plugin.time_ms,
                 stock_ms / (plugin.time_ms - report.plugin_start_ms),
                 report.plugin_start_ms);
  const Difference difference = *report.difference();
  text += format("difference  %.3g degrees, %.3g m at the source's centroid (%.6g, %.6g, %.6g): %s %g degrees, %g m\n",
                 difference.degrees,
                 difference.metres,
                 report.centroid[0],
                 report.centroid[1],
                 report.centroid[2],
                 report.agree() ? "within" : "more than",
                 report.tolerance.degrees,
                 report.tolerance.metres);
  return text;
}

} // namespace pcl_gpu_icp::report
