#include "cli/cloud_pair.h"
#include "cli/commands.h"
#include "cli/icp_settings.h"
#include "cli/options.h"
#include "cli/output_file.h"

#include "report/comparison_report.h"

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/icp.h>

#include <pcl/registration/icp.h>

#include <chrono>
#include <limits>
#include <memory>

namespace pcl_gpu_icp::cli {
namespace {

using PluginIcp = pcl_gpu_icp::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ>;

struct StockIcp : pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> {
  int iterations() const { return nr_iterations_; }
};

struct CompareOptions : AlignmentOptions {
  report::Difference tolerance{0.01, 1e-3};
};

std::optional<double> defined(double score)
{
  return score < std::numeric_limits<double>::max() ? std::optional(score) : std::nullopt;
}

/// Everything but the reason and the iterations, which the classes keep in different places.
template <typename Icp>
report::Run run(Icp& icp, const CloudPair& pair, const CompareOptions& options)
{
  applySettings(icp, options);
  icp.setInputSource(pair.source.points);
  icp.setInputTarget(pair.target.points);
  pcl::PointCloud<pcl::PointXYZ> aligned;
  const auto begin = std::chrono::steady_clock::now();
  icp.align(aligned, detail::toMatrix<float>(pair.guess));
  const auto end = std::chrono::steady_clock::now();

  report::Run run;
  run.converged = icp.hasConverged();
  run.time_ms = std::chrono::duration<double, std::milli>(end - begin).count();
  run.fitness_score = defined(icp.getFitnessScore());
  const double limit = icp.getMaxCorrespondenceDistance();
  run.rmse = defined(icp.getFitnessScore(limit * limit));
  if (run.rmse)
    run.rmse = std::sqrt(*run.rmse);
  run.transform = pair.inFileCoordinates(detail::toRigidTransform<float>(icp.getFinalTransformation()));
  return run;
}

ExitCode compare(const CompareOptions& options)
{
  std::unique_ptr<OutputFile> json;
  if (!options.json.empty() && options.json != "-")
    json = std::make_unique<OutputFile>("--json", options.json, options.force);
  const CloudPair pair = readPair(options);

  PluginIcp plugin;
  plugin.setDevice(Device::select(options.device));
  plugin.setCorrespondenceSearch(options.search);
  plugin.setPipeline(options.pipeline);
  plugin.setAndersonAcceleration(options.anderson);
  plugin.setNumberOfThreads(options.threads);
  StockIcp stock;

  report::ComparisonReport report;
  report.source = options.source;
  report.target = options.target;
  report.source_points = pair.source.points->size();
  report.target_points = pair.target.points->size();
  report.plugin = run(plugin, pair, options);
  const AlignmentResult& result = plugin.getResult();
  if (result.reason == Reason::Error)
    throw Failure(ExitCode::Device, result.message);
  report.plugin.reason = result.reason;
  report.plugin.iterations = result.iterations;
  const auto start = result.host_times.find("start");
  report.plugin_start_ms = start == result.host_times.end() ? 0 : start->second.milliseconds;
  report.device = result.device;
  report.pipeline = result.pipeline;
  report.stock = run(stock, pair, options);
  report.stock.reason = detail::reasonOf(stock.getConvergeCriteria()->getConvergenceState());
  report.stock.iterations = stock.iterations();
  report.centroid = pair.source.centroid;
  report.difference = report::differenceOf(report.stock.transform, report.plugin.transform, report.centroid);
  report.tolerance = options.tolerance;

  if (json) {
    json->write(report::toJson(report));
    json->commit();
  }
  if (options.json == "-")
    writeToStandardOutput(report::toJson(report));
  else if (!options.quiet)
    writeToStandardOutput(report::toText(report));

  const std::string pair_name = options.source + " onto " + options.target + ": ";
  if (!report.bothConverged())
    throw Failure(ExitCode::NotConverged,
                  pair_name + "did not converge: stock PCL " + toString(report.stock.reason) + ", pcl_gpu_icp " +
                      toString(report.plugin.reason));
  if (!report.agree())
    throw Failure(ExitCode::NotConverged, pair_name + "the transforms differ by more than the tolerances");
  return ExitCode::Success;
}

} // namespace

Run addCompare(CLI::App& command)
{
  const auto options = std::make_shared<CompareOptions>();
  addAlignmentOptions(command, *options);
  command.add_option("--tolerance-degrees", options->tolerance.degrees, "exit 1 where the rotations differ by more")
      ->check(positiveNumber())
      ->type_name("DEGREES")
      ->capture_default_str();
  command
      .add_option("--tolerance-distance",
                  options->tolerance.metres,
                  "exit 1 where the images of the source's centroid are farther apart, in the unit of the files")
      ->check(positiveNumber())
      ->type_name("DISTANCE")
      ->capture_default_str();
  return [options] { return compare(*options); };
}

} // namespace pcl_gpu_icp::cli
