// Alignments as the command does them without options, on pairs that have half or more of their points in common, from
// guesses that are off by up to 30 degrees and a tenth of the extent: the right pose is found.
#include "cli/icp_settings.h"
#include "cli/pair_alignment.h"

#include "made_pairs.h"
#include "scans.h"

#include "report/judgement.h"

#include <pcl_gpu_icp/icp_loop.h>
#include <pcl_gpu_icp/search/points_of.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>

namespace pcl_gpu_icp::cli {
namespace {

std::shared_ptr<const PreparedCloud> prepared(const made_pairs::Cloud::Ptr& points)
{
  auto cloud = std::make_shared<PreparedCloud>();
  std::vector<std::array<double, 3>> places;
  for (const auto& point : *points)
    places.push_back({point.x, point.y, point.z});
  cloud->points = points;
  cloud->scale = scaleOf(places);
  const Lever lever = leverOf(search::pointsOf(*points));
  cloud->centroid = lever.centre;
  cloud->extent = 2 * lever.length;
  cloud->counts.in_file = cloud->counts.used = points->size();
  return cloud;
}

struct Answer {
  bool right;
  Verdict verdict;
  double milliseconds;
};

Answer answerOf(const made_pairs::Pair& pair, const AlignmentOptions& options)
{
  const Device device = Device::select();
  StageTimes times;
  const StartSearch search(device, nullptr, times);
  const auto run = [&](const CloudPair& from, const AlignmentOptions& with) {
    IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ, double> icp;
    setUp(icp, from, with, device);
    icp.alignWithoutOutput(detail::toMatrix<double>(from.guess));
    requireNoError(icp.getResult());
    IcpRun done;
    done.result.alignment = icp.getResult();
    done.result.transform = detail::toRigidTransform<double>(icp.getFinalTransformation());
    return done;
  };
  const auto begin = std::chrono::steady_clock::now();
  CloudPair clouds(prepared(pair.source), prepared(pair.target), detail::toRigidTransform<double>(pair.guess.matrix()));
  const report::AlignmentReport report = alignPair(clouds, options, search, run).report;
  const auto end = std::chrono::steady_clock::now();
  constexpr double right_spacings = 3;
  const double spacing = report.result.quality ? report.result.quality->spacing : 0;
  const double off = made_pairs::errorOf(pair, Eigen::Affine3d(toMatrix<double>(report.transform)));
  return {off <= right_spacings * spacing,
          judgementOf(report).verdict,
          std::chrono::duration<double, std::milli>(end - begin).count()};
}

TEST(Starts, OfMadePairsLeadToTheRightPose)
{
  if (!scans::areThere())
    GTEST_SKIP() << "no scans at " << scans::folder << " (CMake variable PCL_GPU_ICP_SHARED_DATA)";
  const char* wanted = std::getenv("STARTS_TRIALS"); // for BENCHMARK.md
  struct Counts {
    int pairs = 0, once = 0, found = 0, good_and_off = 0;
    double once_ms = 0, found_ms = 0;
  };
  std::map<std::string, Counts> kinds;
  AlignmentOptions by_default, once;
  once.once = true;
  for (const made_pairs::Pair& pair : made_pairs::makeNearbyPairs(scans::folder, wanted ? std::atoi(wanted) : 1, 9)) {
    SCOPED_TRACE(pair.kind + " " + pair.clouds);
    const Answer alone = answerOf(pair, once), found = answerOf(pair, by_default);
    if (pair.kind == "shared") {
      EXPECT_TRUE(found.right);
    }
    for (const auto& kind : {pair.kind, std::string("all")}) {
      Counts& counts = kinds[kind];
      ++counts.pairs;
      counts.once += alone.right ? 1 : 0;
      counts.found += found.right ? 1 : 0;
      counts.good_and_off += !found.right && found.verdict == Verdict::Good ? 1 : 0;
      counts.once_ms += alone.milliseconds;
      counts.found_ms += found.milliseconds;
    }
  }
  if (wanted)
    for (const auto& [kind, counts] : kinds)
      std::printf("| %s | %d | %d | %d | %.0f ms | %.0f ms |\n",
                  kind.c_str(),
                  counts.pairs,
                  counts.once,
                  counts.found,
                  counts.once_ms / counts.pairs,
                  counts.found_ms / counts.pairs);
  const Counts& all = kinds["all"];
  ASSERT_GE(all.pairs, 10);
  EXPECT_GE(all.found, all.pairs * 9 / 10);
  EXPECT_LE(all.good_and_off, std::max(1, all.pairs / 100));
  EXPECT_GT(all.found, all.once);
}

} // namespace
} // namespace pcl_gpu_icp::cli
