// Real scans: the same transform as stock PCL, or closer to stock PCL in double.
#include "parity.h"
#include "scans.h"

using pcl::PointXYZ;
using pcl_gpu_icp::CorrespondenceSearch;
using Cloud = pcl::PointCloud<PointXYZ>;

namespace {

void expectSameAsStockOrBetter(const Cloud::Ptr& source, const Cloud::Ptr& target, int iterations)
{
  const auto run = [&](auto&& icp, auto guess) {
    return alignWith(
        icp, source, target, [&](auto& i) { i.setMaximumIterations(iterations); }, guess.eval());
  };
  const auto stock = run(pcl::IterativeClosestPoint<PointXYZ, PointXYZ>(), Eigen::Matrix4f::Identity());
  const auto reference = run(pcl::IterativeClosestPoint<PointXYZ, PointXYZ, double>(), Eigen::Matrix4d::Identity());
  const auto distance = [&](const Eigen::Matrix4d& a, const Eigen::Matrix4d& b) {
    return (a - b).topRightCorner<3, 1>().norm();
  };
  const Eigen::Matrix4d stock_double = stock.transformation.cast<double>();
  const double scale = std::max(1e-3, stock_double.topRightCorner<3, 1>().norm());
  for (const CorrespondenceSearch search : {CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree}) {
    SCOPED_TRACE(toString(search));
    pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ> icp;
    icp.setCorrespondenceSearch(search);
    const auto outcome = run(icp, Eigen::Matrix4f::Identity());
    const Eigen::Matrix4d ours = outcome.transformation.cast<double>();
    const bool same =
        distance(ours, stock_double) < 1e-4 * scale && scenes::degreesBetween<double>(ours, stock_double) < 0.01;
    const bool closer = distance(ours, reference.transformation) <= distance(stock_double, reference.transformation) &&
                        scenes::degreesBetween<double>(ours, reference.transformation) <=
                            std::max(1e-3, scenes::degreesBetween<double>(stock_double, reference.transformation));
    EXPECT_TRUE(same || closer) << "ours\n"
                                << ours << "\nstock\n"
                                << stock_double << "\nin double\n"
                                << reference.transformation;
    // What getFitnessScore answers from kept matches is what stock PCL searches every point for.
    pcl::Registration<PointXYZ, PointXYZ>& as_pcl_has_it = icp;
    EXPECT_NEAR(outcome.fitness, as_pcl_has_it.getFitnessScore(), 1e-4 * outcome.fitness + 1e-8);
    EXPECT_EQ(icp.getResult().searched.size(), std::size_t(icp.getResult().iterations));
  }
}

class RealScans : public testing::Test {
protected:
  void SetUp() override
  {
    if (!scans::areThere())
      GTEST_SKIP() << "no scans at " << scans::folder << " (CMake variable PCL_GPU_ICP_SHARED_DATA)";
  }
};

} // namespace

TEST_F(RealScans, Bunny) { expectSameAsStockOrBetter(scans::read("bunny_0.pcd"), scans::read("bunny_45.pcd"), 30); }

TEST_F(RealScans, LidarStreet)
{
  expectSameAsStockOrBetter(scans::read("lidar_street_1.pcd"), scans::read("lidar_street_0.pcd"), 10);
}

TEST_F(RealScans, LidarStreetInVoxels)
{
  expectSameAsStockOrBetter(scans::read("lidar_street_1.pcd", 0.25F), scans::read("lidar_street_0.pcd", 0.25F), 30);
}

TEST_F(RealScans, RgbdRoom)
{
  expectSameAsStockOrBetter(scans::read("rgbd_room_1.pcd"), scans::read("rgbd_room_0.pcd"), 5);
}

TEST_F(RealScans, TerrainInUtm)
{
  const auto target = scans::read("terrain_utm.pcd");
  Cloud::Ptr source(new Cloud(*target));
  for (auto& point : *source)
    point.getVector3fMap() += Eigen::Vector3f(1, -1, 0.5F);
  expectSameAsStockOrBetter(source, target, 5);
}
