#include "cli/cloud_file.h"
#include "cli/cloud_pair.h"
#include "cli/commands.h"
#include "cli/compilation_notice.h"
#include "cli/guess.h"
#include "cli/help.h"
#include "cli/icp_settings.h"
#include "cli/interruption.h"
#include "cli/options.h"
#include "cli/output_file.h"
#include "cli/shown_pair.h"
#include "cli/stock_process.h"
#include "cli/this_run.h"

#include "report/comparison_report.h"
#include "report/ending.h"
#include "report/judgement.h"
#include "view/pair_page.h"
#include "view/text.h"

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/normal_estimator.h>

#include <pcl/common/io.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/transformation_estimation_point_to_plane_lls.h>
#include <pcl/registration/transformation_estimation_symmetric_point_to_plane_lls.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

namespace pcl_gpu_icp::cli {
namespace {

using pcl::PointNormal;
using pcl::PointXYZ;
using PluginIcp = pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ>;

template <typename PointT>
struct StockIcp : pcl::IterativeClosestPoint<PointT, PointT> {
  int iterations() const { return this->nr_iterations_; }
};

/// With ICP's default limit and the meaning of ICP's epsilons, as the plugin's run has. It keeps no reason: it ends
/// where the pose no longer changes, or at the limit.
struct StockGeneralizedIcp : pcl::GeneralizedIterativeClosestPoint<PointXYZ, PointXYZ> {
  StockGeneralizedIcp() { setMaxCorrespondenceDistance(std::sqrt(std::numeric_limits<double>::max())); }
  void setTransformationEpsilon(double squared) { transformation_epsilon_ = std::sqrt(squared); }
  void setTransformationRotationEpsilon(double cosine) { setRotationEpsilon(std::acos(cosine)); }
  int iterations() const { return this->nr_iterations_; }
  Reason reason() const
  {
    return !this->hasConverged()                           ? Reason::NoCorrespondences
           : this->nr_iterations_ >= this->max_iterations_ ? Reason::Iterations
                                                           : Reason::Transform;
  }
};

struct CompareOptions : AlignmentOptions {
  report::Difference tolerance{0.01, 1e-3};
  double stock_limit_s = 600;
};

std::optional<double> defined(double score)
{
  return score < std::numeric_limits<double>::max() ? std::optional(score) : std::nullopt;
}

template <typename PointT>
using CloudPtr = typename pcl::PointCloud<PointT>::Ptr;

/// Everything but the reason and the iterations, which the classes keep in different places.
template <typename PointT, typename Icp>
report::Run run(Icp& icp,
                const CloudPtr<PointT>& source,
                const CloudPtr<PointT>& target,
                const CloudPair& pair,
                const CompareOptions& options)
{
  applySettings(icp, options);
  icp.setInputSource(source);
  icp.setInputTarget(target);
  pcl::PointCloud<PointT> aligned;
  const auto begin = std::chrono::steady_clock::now();
  icp.align(aligned, detail::toMatrix<float>(pair.guess));
  const auto end = std::chrono::steady_clock::now();

  if (!icp.getFinalTransformation().allFinite())
    throw std::runtime_error("its transform is not finite");
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

template <typename PointT>
report::Run runStock(StockIcp<PointT>& icp,
                     const CloudPtr<PointT>& source,
                     const CloudPtr<PointT>& target,
                     const CloudPair& pair,
                     const CompareOptions& options)
{
  report::Run stock = run<PointT>(icp, source, target, pair, options);
  stock.reason = detail::reasonOf(icp.getConvergeCriteria()->getConvergenceState());
  stock.iterations = icp.iterations();
  return stock;
}

CloudPtr<PointNormal> withNormals(const pcl::PointCloud<PointXYZ>& points,
                                  const StockProcess::Normals::value_type* normal)
{
  const auto cloud = pcl::make_shared<pcl::PointCloud<PointNormal>>();
  pcl::copyPointCloud(points, *cloud);
  for (PointNormal& point : *cloud) {
    point.getNormalVector3fMap() = Eigen::Vector3f((*normal)[0], (*normal)[1], (*normal)[2]);
    ++normal;
  }
  return cloud;
}

/// \param normals as normalsOf() makes them
report::Run runStock(const CloudPair& pair, const CompareOptions& options, const StockProcess::Normals& normals)
{
  const auto& source = pair.source->points;
  const auto& target = pair.target->points;
  if (options.metric == Metric::Point) {
    StockIcp<PointXYZ> icp;
    return runStock<PointXYZ>(icp, source, target, pair, options);
  }
  if (options.metric == Metric::Generalized) {
    StockGeneralizedIcp icp;
    report::Run stock = run<PointXYZ>(icp, source, target, pair, options);
    stock.reason = icp.reason();
    stock.iterations = icp.iterations();
    return stock;
  }
  StockIcp<PointNormal> icp;
  namespace stock = pcl::registration;
  if (options.metric == Metric::Symmetric)
    icp.setTransformationEstimation(
        pcl::make_shared<stock::TransformationEstimationSymmetricPointToPlaneLLS<PointNormal, PointNormal>>());
  else
    icp.setTransformationEstimation(
        pcl::make_shared<stock::TransformationEstimationPointToPlaneLLS<PointNormal, PointNormal>>());
  return runStock<PointNormal>(
      icp, withNormals(*source, normals.data()), withNormals(*target, normals.data() + source->size()), pair, options);
}

/// Those that the plugin estimates for itself, of the source and then of the target: stock is given them where its
/// metric takes normals.
StockProcess::Normals normalsOf(const CloudPair& pair, const CompareOptions& options, const Device& device)
{
  if (options.metric != Metric::Plane && options.metric != Metric::Symmetric)
    return {};
  NormalEstimator estimator(device, detail::precisionFor<float>(device));
  auto normals = estimator.estimate(search::pointsOf(*pair.source->points));
  const auto of_target = estimator.estimate(search::pointsOf(*pair.target->points));
  normals.insert(normals.end(), of_target.begin(), of_target.end());
  return normals;
}

struct PluginRun {
  report::AlignmentReport alignment;
  std::vector<double> errors; ///< of the pairs, by iteration
};

PluginRun
runPlugin(report::ComparisonReport& report, const CloudPair& pair, const CompareOptions& options, const Device& device)
{
  PluginIcp plugin;
  applyPluginSettings(plugin, options, device);
  PluginRun done;
  plugin.setIterationCallback([&done](int, double rmse, std::size_t) { done.errors.push_back(rmse); });
  report.plugin = run<PointXYZ>(plugin, pair.source->points, pair.target->points, pair, options);
  report::AlignmentReport& alignment = done.alignment;
  alignment.source = options.source;
  alignment.target = options.target;
  alignment.result = plugin.getResult();
  const AlignmentResult& result = alignment.result;
  requireNoError(result);
  describe(alignment, options, pair, detail::toRigidTransform<float>(plugin.getFinalTransformation()));
  report.plugin.converged = isAnswer(endingOf(alignment));
  report.judgement = judgementOf(alignment);
  report.plugin.reason = result.reason;
  report.plugin.iterations = result.iterations;
  const auto start = result.host_times.find("start");
  report.plugin_start_ms = start == result.host_times.end() ? 0 : start->second.milliseconds;
  report.device = result.device;
  report.pipeline = result.pipeline;
  report.metric = result.metric;
  return done;
}

ExitCode compare(const CompareOptions& options)
{
  if (options.metric == Metric::Generalized && (options.trim || options.reciprocal))
    throw Failure(ExitCode::Usage,
                  "--metric gicp: stock PCL's ignores --trim and --reciprocal, so there is nothing to compare");
  if (!options.preset.empty() && options.loss.weighs() && !options.loss_is_given)
    throw Failure(ExitCode::Usage,
                  "--preset " + options.preset + ": it sets --loss " + toString(options.loss.function) +
                      ", which stock PCL has not, so there is nothing to compare; --loss none leaves its --metric " +
                      toString(options.metric));
  if (options.loss.weighs() || options.motions != Motions::Rigid || options.undetermined == Undetermined::Keep)
    throw Failure(
        ExitCode::Usage,
        "--loss, --motions and --degenerate keep: stock PCL has none of them, so there is nothing to compare");
  if (options.finds_overlap)
    throw Failure(ExitCode::Usage, "--overlap auto: stock PCL has no such search, so there is nothing to compare");
  if (options.guess && asksForSearch(*options.guess))
    throw Failure(ExitCode::Usage, "--guess auto: stock PCL has no search, so there is nothing to compare");
  std::unique_ptr<OutputFile> json, page;
  if (!options.json.empty() && options.json != "-")
    json = std::make_unique<OutputFile>("--json", options.json, options.force);
  if (!options.report.empty())
    page = std::make_unique<OutputFile>("--report", options.report, options.force);
  requireDistinct({json.get(), page.get()});
  LiveLine line(!options.quiet);
  const CloudPair pair = readPair(options, [&](const std::string& path) {
    line.show("reading " + view::fileNameOf(path));
    return std::make_shared<const PreparedCloud>(prepare(readCloudArgument(path), path, options));
  });
  line.clear();
  if (!options.quiet)
    print(pair.warnings);

  StockProcess stock([&](const StockProcess::Normals& normals) { return runStock(pair, options, normals); });
  const Interruption interruption(endAtOnce); // its thread after the fork: a copy has no threads to free their locks
  const Device device = Device::select(options.device);

  report::ComparisonReport report;
  report.arguments = argumentsOfThisRun();
  report.source = options.source;
  report.target = options.target;
  report.source_points = pair.source->points->size();
  report.target_points = pair.target->points->size();
  std::optional<CompilationNotice> notice(std::in_place, line, !options.quiet);
  const PluginRun done = runPlugin(report, pair, options, device);
  const report::AlignmentReport& alignment = done.alignment;
  report.centroid = pair.source->centroid;
  report.tolerance = options.tolerance;
  const auto answer = stock.ask(normalsOf(pair, options, device), std::chrono::duration<double>(options.stock_limit_s));
  if (const auto* run = std::get_if<report::Run>(&answer))
    report.stock = *run;
  else
    report.stock_failure = std::get<std::string>(answer);
  notice.reset();

  if (json)
    json->write(report::toJson(report));
  if (page) {
    std::vector<view::NamedPose> poses{{"before", pair.inFileCoordinates(pair.guess)},
                                       {"pcl_gpu_icp", report.plugin.transform}};
    if (report.stock)
      poses.push_back({"stock PCL", report.stock->transform});
    page->write(comparisonPage(report, alignment, shownPair(pair, poses), done.errors, thisRun()));
  }
  OutputFile::commit({json.get(), page.get()});
  if (options.json == "-")
    writeToStandardOutput(report::toJson(report));
  else if (!options.quiet)
    writeToStandardOutput(report::toText(report));

  const auto fail = [&](const std::string& why) {
    throw Failure(ExitCode::NotConverged, options.source + " onto " + options.target + ": " + why);
  };
  if (!report.plugin.converged)
    fail("ours: " + endingText(alignment) + "; " + stockText(report));
  if (!report.stock || !report.stock->converged)
    fail(stockText(report));
  if (!report.agree())
    fail("the transforms differ by more than the tolerances");
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
      ->capture_default_str()
      ->group(group::comparison);
  command
      .add_option("--tolerance-distance",
                  options->tolerance.metres,
                  "exit 1 where the images of the source's centroid are farther apart, in the unit of the files")
      ->check(positiveNumber())
      ->type_name("DISTANCE")
      ->capture_default_str()
      ->group(group::comparison);
  command
      .add_option("--stock-limit", options->stock_limit_s, "how long stock PCL may take before it counts as no answer")
      ->check(positiveNumber())
      ->type_name("SECONDS")
      ->capture_default_str()
      ->group(group::comparison);
  command.footer(
      exampleText({{"Stock PCL and the device with PCL's defaults", "pcl_gpu_icp compare source.pcd target.pcd"},
                   {"Planes, both stopped after 30 iterations, as a page to look at",
                    "pcl_gpu_icp compare source.ply target.ply --metric plane --iterations 30 \\\n        --report "
                    "comparison.html"},
                   {"On the CPU, and differences that are allowed, as JSON",
                    "pcl_gpu_icp compare source.pcd target.pcd --device cpu \\\n        --tolerance-degrees 0.1 "
                    "--tolerance-distance 0.01 --json -"}}));
  return [options] { return compare(*options); };
}

} // namespace pcl_gpu_icp::cli
