// OverlapSearch on pairs that have half or more of their points in common, from guesses that are off by up to 30
// degrees and a tenth of the extent: ICP from where it ends is right, where ICP alone is pulled away.
#include "made_pairs.h"
#include "scans.h"
#include "scenes.h"

#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/matrix.h>
#include <pcl_gpu_icp/overlap_search.h>
#include <pcl_gpu_icp/search/points_of.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>

namespace pcl_gpu_icp::test {
namespace {

using pcl::PointXYZ;
using scans::Cloud;

Eigen::Affine3d
aligned(const Cloud::Ptr& source, const Cloud::Ptr& target, const Eigen::Matrix4d& guess, const Loss& loss = {})
{
  IterativeClosestPoint<PointXYZ, PointXYZ, double> icp;
  icp.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree);
  icp.setMaximumIterations(60);
  icp.setMetric(Metric::Plane);
  icp.setLoss(loss);
  icp.setMeasureQuality(false);
  icp.setInputSource(source);
  icp.setInputTarget(target);
  icp.alignWithoutOutput(guess);
  return Eigen::Affine3d(icp.getFinalTransformation());
}

TEST(OverlapSearch, LeadsToTheRightPoseWhereIcpAloneDoesNot)
{
  if (!scans::areThere())
    GTEST_SKIP() << "no scans at " << scans::folder << " (CMake variable PCL_GPU_ICP_SHARED_DATA)";
  const char* wanted = std::getenv("OVERLAP_TRIALS"); // for BENCHMARK.md
  struct Counts {
    int pairs = 0, alone = 0, found = 0;
  };
  std::map<std::string, Counts> kinds;
  const OverlapSearch search{Device::select()};
  for (const made_pairs::Pair& pair : made_pairs::makeNearbyPairs(scans::folder, wanted ? std::atoi(wanted) : 1, 5)) {
    SCOPED_TRACE(pair.kind + " " + pair.clouds);
    const Points source = search::pointsOf(*pair.source), target = search::pointsOf(*pair.target);
    const Eigen::Matrix4d guess = pair.guess.matrix();
    const OverlapSearchResult found = search.search(source, target, detail::toRigidTransform<double>(guess));
    ASSERT_GT(found.ways, 0U);
    const double right = 3 * found.quality.spacing;
    const Loss loss{LossFunction::GemanMcClure, found.quality.spacing};
    const auto isRight = [&](const Eigen::Affine3d& answer) {
      return made_pairs::errorOf(pair, answer) <= right ? 1 : 0;
    };
    const int alone = isRight(aligned(pair.source, pair.target, guess));
    const int from_there = isRight(aligned(pair.source, pair.target, toMatrix<double>(found.transform), loss));
    for (const auto& kind : {pair.kind, std::string("all")}) {
      ++kinds[kind].pairs;
      kinds[kind].alone += alone;
      kinds[kind].found += from_there;
    }
  }
  if (wanted)
    for (const auto& [kind, counts] : kinds)
      std::printf("| %s | %d | %d | %d |\n", kind.c_str(), counts.pairs, counts.alone, counts.found);
  const Counts& all = kinds["all"];
  EXPECT_GE(all.found, all.pairs * 9 / 10);
  EXPECT_GE(all.found, all.alone + all.pairs / 8);
}

TEST(OverlapSearch, TellsTheShareInCommonAndGivesTheSameBits)
{
  const Cloud::Ptr all = scenes::hills<PointXYZ>(8000, 1), others = scenes::hills<PointXYZ>(8000, 2);
  const Cloud::Ptr source(new Cloud), target(new Cloud);
  for (const PointXYZ& point : *all)
    if (point.x < 0.4F)
      source->push_back(point);
  for (const PointXYZ& point : *others)
    if (point.x > -1.0F)
      target->push_back(point);
  const OverlapSearch search{Device::select()};
  const RigidTransform guess = detail::toRigidTransform<float>(scenes::smallMotion().matrix());
  const OverlapSearchResult found = search.search(search::pointsOf(*source), search::pointsOf(*target), guess);
  EXPECT_NEAR(found.quality.after.source, 1.4 / 2.4, 0.15); // by length along x, without the margin of three spacings
  EXPECT_LT(scenes::degreesBetween<double>(toMatrix<double>(found.transform), Eigen::Matrix4d::Identity()), 1);
  const OverlapSearchResult again = search.search(search::pointsOf(*source), search::pointsOf(*target), guess);
  EXPECT_EQ(found.transform.rotation, again.transform.rotation);
  EXPECT_EQ(found.transform.translation, again.transform.translation);
}

TEST(OverlapSearch, KeepsToTheMotionsAllowed)
{
  const Cloud::Ptr target = scenes::hills<PointXYZ>(4000, 1);
  const Cloud::Ptr source = scenes::moved(*target,
                                          Eigen::Translation3f(0.1F, 0.2F, -0.1F) *
                                              Eigen::Affine3f(Eigen::AngleAxisf(0.2F, Eigen::Vector3f::UnitZ())));
  OverlapSearch search{Device::select()};
  search.setMotions(Motions::Yaw);
  const OverlapSearchResult found = search.search(search::pointsOf(*source), search::pointsOf(*target));
  EXPECT_NEAR(found.transform.rotation[8], 1, 1e-12);
  EXPECT_NEAR(std::atan2(found.transform.rotation[3], found.transform.rotation[0]), -0.2, 0.01);
}

TEST(OverlapSearch, LeavesTheGuessWhereThereIsTooLittle)
{
  Cloud few, one_place;
  for (int i = 0; i < 50; ++i) {
    if (i < 5)
      few.emplace_back(static_cast<float>(i), 0.0F, 1.0F);
    one_place.emplace_back(1.0F, 2.0F, 3.0F);
  }
  const Cloud::Ptr hills = scenes::hills<PointXYZ>(100);
  const OverlapSearch search{Device::select()};
  const RigidTransform guess{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {1, 2, 3}};
  for (const Cloud* cloud : {&few, &one_place}) {
    const OverlapSearchResult found = search.search(search::pointsOf(*cloud), search::pointsOf(*hills), guess);
    EXPECT_EQ(found.ways, 0U);
    EXPECT_EQ(found.transform.translation, guess.translation);
  }
  EXPECT_EQ(search.search(search::pointsOf(*hills), search::pointsOf(one_place), guess).ways, 0U);
}

} // namespace
} // namespace pcl_gpu_icp::test
