// PoseSearch on real scans that were turned and shifted anyhow: ICP from the pose found ends where it belongs.
#include "scans.h"
#include "scenes.h"

#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/matrix.h>
#include <pcl_gpu_icp/pose_search.h>
#include <pcl_gpu_icp/search/points_of.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

namespace pcl_gpu_icp::test {
namespace {

using pcl::PointXYZ;
using scans::Cloud;

struct Pair {
  const char* source;
  const char* target;
  float leaf;
};

// A scan and itself, and two of one place.
const Pair pairs[] = {
    {"bunny_0.pcd", "bunny_0.pcd", 0},
    {"bunny_45.pcd", "bunny_0.pcd", 0},
    {"lidar_street_0.pcd", "lidar_street_0.pcd", 0.25F},
    {"lidar_street_1.pcd", "lidar_street_0.pcd", 0.25F},
    {"rgbd_room_0.pcd", "rgbd_room_0.pcd", 0.03F},
    {"rgbd_room_1.pcd", "rgbd_room_0.pcd", 0.03F},
    {"terrain_utm.pcd", "terrain_utm.pcd", 0},
};

Eigen::Affine3f anyMotion(std::mt19937& generator, float reach)
{
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> shift(-reach, reach);
  const Eigen::Quaternionf turn(normal(generator), normal(generator), normal(generator), normal(generator));
  return Eigen::Translation3f(shift(generator), shift(generator), shift(generator)) * turn.normalized();
}

Eigen::Matrix4f aligned(const Cloud::Ptr& source, const Cloud::Ptr& target, const Eigen::Matrix4f& guess)
{
  IterativeClosestPoint<PointXYZ, PointXYZ> icp;
  icp.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree);
  icp.setMaximumIterations(100);
  icp.setMetric(Metric::Plane);
  icp.setInputSource(source);
  icp.setInputTarget(target);
  Cloud output;
  icp.align(output, guess);
  return icp.getFinalTransformation();
}

/// As float32 keeps the digits of: about the first point.
void recentre(Cloud& cloud)
{
  const Eigen::Vector3f first = cloud[0].getVector3fMap();
  for (PointXYZ& point : cloud)
    point.getVector3fMap() -= first;
}

TEST(PoseSearchOnRealScans, EndsWhereAnAlignmentFromTheTruthEnds)
{
  if (!scans::areThere())
    GTEST_SKIP() << "no scans at " << scans::folder << " (CMake variable PCL_GPU_ICP_SHARED_DATA)";
  const char* wanted = std::getenv("POSE_SEARCH_TRIALS"); // for BENCHMARK.md
  const int trials = wanted ? std::atoi(wanted) : 1;
  std::mt19937 generator(3);
  const PoseSearch search{Device::select()};
  int right = 0;
  for (const Pair& pair : pairs) {
    SCOPED_TRACE(pair.source + std::string(" onto ") + pair.target);
    const Cloud::Ptr scan = scans::read(pair.source, pair.leaf), target = scans::read(pair.target, pair.leaf);
    if (pair.source == pairs[6].source) {
      recentre(*scan);
      recentre(*target);
    }
    const Eigen::Matrix4f truth = aligned(scan, target, Eigen::Matrix4f::Identity());
    const double radius = surfaceSpacing(search::pointsOf(*scan)) * std::sqrt(scan->size()) / 2.5;
    for (int trial = 0; trial < trials; ++trial) {
      const Eigen::Affine3f away = anyMotion(generator, static_cast<float>(radius));
      const Cloud::Ptr source = scenes::moved(*scan, away);
      const PoseSearchResult found = search.search(search::pointsOf(*source), search::pointsOf(*target));
      ASSERT_FALSE(found.poses.empty());
      const Eigen::Matrix4f guess = toMatrix(found.poses[0].transform);
      const Eigen::Matrix4f answer = aligned(source, target, guess) * away.matrix();
      const double degrees = scenes::degreesBetween<float>(answer, truth);
      const double off = (answer - truth).topRightCorner<3, 1>().norm();
      EXPECT_LT(degrees, 1) << trial;
      EXPECT_LT(off, 0.02 * radius) << trial;
      right += degrees < 1 && off < 0.02 * radius ? 1 : 0;
    }
  }
  RecordProperty("right", right);
}

} // namespace
} // namespace pcl_gpu_icp::test
