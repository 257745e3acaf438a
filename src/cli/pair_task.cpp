#include "cli/pair_task.h"

#include "cli/failure.h"
#include "cli/guess_search.h"
#include "cli/icp_settings.h"
#include "cli/shown_pair.h"

#include <pcl_gpu_icp/error.h>
#include <pcl_gpu_icp/stopwatch.h>

namespace pcl_gpu_icp::cli {

BatchResult PairTask::run(DeviceLane& lane)
{
  try {
    return align(lane);
  } catch (const Cancelled&) {
    throw;
  } catch (...) {
    const Failure failure = failureOf(std::current_exception());
    failure_ = report::PairFailure{toString(failure.code()), failure.what()};
    throw;
  }
}

CloudPair PairTask::read()
{
  const AlignmentOptions& options = pair_->alignment;
  return readPair(options, [&](const std::string& path) {
    return clouds_->get({path, options.drop_zero_returns, options.leaf}, [&] { return readPrepared(path, options); });
  });
}

BatchResult PairTask::align(DeviceLane& lane)
{
  AlignmentOptions options = pair_->alignment;
  report::AlignmentReport report;
  report.source = pair_->identity.source;
  report.target = pair_->identity.target;
  std::optional<Stopwatch> total(std::in_place, report.command_times, "total");
  std::optional<Stopwatch> reading(std::in_place, report.command_times, "read");
  CloudPair clouds = read();
  const RigidTransform start = clouds.guess;
  reading.reset();
  report.searched_guess = searchGuess(clouds, options, lane.device, lane.share, report.command_times);
  report.found_overlap = findOverlap(clouds, options, lane.device, lane.share, report.command_times);
  IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ, double> icp;
  applySettings(icp, options);
  applyPluginSettings(icp, options, lane.device);
  icp.setInputSource(clouds.source->points);
  icp.setInputTarget(clouds.target->points);
  std::vector<double> errors;
  icp.setIterationCallback([&errors](int, double rmse, std::size_t) { errors.push_back(rmse); });
  BatchResult result = BatchAligner::align(lane, icp, detail::toMatrix<double>(clouds.guess), true);
  total.reset();

  requireNoError(result.alignment);
  if (result.alignment.reason == Reason::Cancelled)
    return result;
  report.result = result.alignment;
  report.fitness_score = result.fitness_score;
  describe(report, options, clouds, result.transform);
  if (shown_points_ > 0)
    shown_ = {
        pair_->identity.pair,
        shownPair(clouds, {{"before", clouds.inFileCoordinates(start)}, {"after", report.transform}}, shown_points_),
        std::move(errors)};
  report_ = std::move(report);
  return result;
}

} // namespace pcl_gpu_icp::cli
