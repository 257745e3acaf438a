#include "cli/pair_task.h"

#include "cli/failure.h"
#include "cli/icp_settings.h"
#include "cli/pair_alignment.h"
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
  StageTimes times;
  std::optional<Stopwatch> total(std::in_place, times, "total");
  std::optional<Stopwatch> reading(std::in_place, times, "read");
  const CloudPair clouds = read();
  reading.reset();
  const StartSearch search(lane.device, lane.share, times);
  const auto run = [&lane](const CloudPair& pair, const AlignmentOptions& options) {
    IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ, double> icp;
    setUp(icp, pair, options, lane.device);
    IcpRun done;
    icp.setIterationCallback([&done](int, double rmse, std::size_t) { done.errors.push_back(rmse); });
    done.result = BatchAligner::align(lane, icp, detail::toMatrix<double>(pair.guess), true);
    requireNoError(done.result.alignment);
    if (done.result.alignment.reason == Reason::Cancelled)
      throw Cancelled(done.result.alignment.message);
    return done;
  };
  auto [report, errors] = alignPair(clouds, pair_->alignment, search, run);
  total.reset();
  report.command_times = std::move(times);
  report.source = pair_->identity.source;
  report.target = pair_->identity.target;
  if (shown_points_ > 0)
    shown_ = {pair_->identity.pair, shownPair(clouds, posesOf(report, clouds), shown_points_), std::move(errors)};
  BatchResult result;
  result.alignment = report.result;
  report_ = std::move(report);
  return result;
}

} // namespace pcl_gpu_icp::cli
