#pragma once

#include "made_pairs.h"

#include "cli/icp_settings.h"
#include "cli/pair_alignment.h"

#include "report/alignment_report.h"
#include "report/judgement.h"

#include <pcl_gpu_icp/search/points_of.h>
#include <pcl_gpu_icp/stopwatch.h>

#include <array>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace made_pairs {

/// What the command would say of a pair, and whether its pose is right.
struct StartedPair {
  pcl_gpu_icp::report::AlignmentReport report;
  double off; ///< spacings, root mean square over the source
  double milliseconds;

  bool isRight() const { return off <= right_spacings; }
  pcl_gpu_icp::Verdict verdict() const { return judgementOf(report).verdict; }
};

inline std::shared_ptr<const pcl_gpu_icp::cli::PreparedCloud> prepared(const Cloud::Ptr& points)
{
  using namespace pcl_gpu_icp;
  auto cloud = std::make_shared<cli::PreparedCloud>();
  std::vector<std::array<double, 3>> places;
  for (const auto& point : *points)
    places.push_back({point.x, point.y, point.z});
  cloud->points = points;
  cloud->scale = cli::scaleOf(places);
  const Lever lever = leverOf(search::pointsOf(*points));
  cloud->centroid = lever.centre;
  cloud->extent = 2 * lever.length;
  cloud->counts.in_file = cloud->counts.used = points->size();
  return cloud;
}

/// Aligns as the command does from the pair's guess, as if that were none that was given.
inline StartedPair started(const Pair& pair, const pcl_gpu_icp::cli::AlignmentOptions& options)
{
  using namespace pcl_gpu_icp;
  const Device device = Device::select();
  StageTimes times;
  const cli::StartSearch search(device, nullptr, times);
  const auto run = [&](const cli::CloudPair& from, const cli::AlignmentOptions& with) {
    IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ, double> icp;
    cli::setUp(icp, from, with, device);
    icp.alignWithoutOutput(pcl_gpu_icp::detail::toMatrix<double>(from.guess));
    cli::requireNoError(icp.getResult());
    cli::IcpRun done;
    done.result.alignment = icp.getResult();
    done.result.transform = pcl_gpu_icp::detail::toRigidTransform<double>(icp.getFinalTransformation());
    return done;
  };
  std::optional<Stopwatch> total(std::in_place, times, "total");
  const cli::CloudPair clouds(
      prepared(pair.source), prepared(pair.target), pcl_gpu_icp::detail::toRigidTransform<double>(pair.guess.matrix()));
  report::AlignmentReport report = alignPair(clouds, options, search, run).report;
  total.reset();
  const double spacing = report.result.quality ? report.result.quality->spacing : 0;
  const double off = errorOf(pair, Eigen::Affine3d(toMatrix<double>(report.transform)));
  return {std::move(report), off / spacing, times.at("total").milliseconds};
}

} // namespace made_pairs
