// Real scans: the same transform as stock PCL, or closer to stock PCL in double.
#include "parity.h"

#include <pcl/filters/filter.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/io/pcd_io.h>

#include <filesystem>

using pcl::PointXYZ;
using Cloud = pcl::PointCloud<PointXYZ>;

namespace {

const std::filesystem::path folder = PCL_GPU_ICP_SHARED_DATA;

Cloud::Ptr scan(const std::string& name, float leaf = 0)
{
  Cloud::Ptr cloud(new Cloud), filtered(new Cloud);
  if (pcl::io::loadPCDFile((folder / name).string(), *cloud) != 0)
    throw std::runtime_error("cannot read " + name);
  cloud->is_dense = false;
  pcl::Indices kept;
  pcl::removeNaNFromPointCloud(*cloud, *filtered, kept);
  if (leaf > 0) {
    pcl::VoxelGrid<PointXYZ> grid;
    grid.setLeafSize(leaf, leaf, leaf);
    grid.setInputCloud(filtered);
    grid.filter(*cloud);
    return cloud;
  }
  return filtered;
}

void expectSameAsStockOrBetter(const Cloud::Ptr& source, const Cloud::Ptr& target, int iterations)
{
  const auto run = [&](auto&& icp, auto guess) {
    return alignWith(
        icp, source, target, [&](auto& i) { i.setMaximumIterations(iterations); }, guess.eval());
  };
  const auto stock = run(pcl::IterativeClosestPoint<PointXYZ, PointXYZ>(), Eigen::Matrix4f::Identity());
  const auto reference = run(pcl::IterativeClosestPoint<PointXYZ, PointXYZ, double>(), Eigen::Matrix4d::Identity());
  const auto ours = run(pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ>(), Eigen::Matrix4f::Identity());

  const auto distance = [&](const Eigen::Matrix4d& a, const Eigen::Matrix4d& b) {
    return (a - b).topRightCorner<3, 1>().norm();
  };
  const Eigen::Matrix4d ours_double = ours.transformation.cast<double>(),
                        stock_double = stock.transformation.cast<double>();
  const double scale = std::max(1e-3, stock_double.topRightCorner<3, 1>().norm());
  const bool same = distance(ours_double, stock_double) < 1e-4 * scale &&
                    scenes::degreesBetween<double>(ours_double, stock_double) < 0.01;
  const bool closer =
      distance(ours_double, reference.transformation) <= distance(stock_double, reference.transformation) &&
      scenes::degreesBetween<double>(ours_double, reference.transformation) <=
          std::max(1e-3, scenes::degreesBetween<double>(stock_double, reference.transformation));
  EXPECT_TRUE(same || closer) << "ours\n"
                              << ours_double << "\nstock\n"
                              << stock_double << "\nin double\n"
                              << reference.transformation;
}

class RealScans : public testing::Test {
protected:
  void SetUp() override
  {
    if (!std::filesystem::exists(folder))
      GTEST_SKIP() << "no scans at " << folder << " (CMake variable PCL_GPU_ICP_SHARED_DATA)";
  }
};

} // namespace

TEST_F(RealScans, Bunny) { expectSameAsStockOrBetter(scan("bunny_0.pcd"), scan("bunny_45.pcd"), 30); }

TEST_F(RealScans, LidarStreet)
{
  expectSameAsStockOrBetter(scan("lidar_street_1.pcd"), scan("lidar_street_0.pcd"), 10);
}

TEST_F(RealScans, LidarStreetInVoxels)
{
  expectSameAsStockOrBetter(scan("lidar_street_1.pcd", 0.25F), scan("lidar_street_0.pcd", 0.25F), 30);
}

TEST_F(RealScans, RgbdRoom) { expectSameAsStockOrBetter(scan("rgbd_room_1.pcd"), scan("rgbd_room_0.pcd"), 5); }

TEST_F(RealScans, TerrainInUtm)
{
  const auto target = scan("terrain_utm.pcd");
  Cloud::Ptr source(new Cloud(*target));
  for (auto& point : *source)
    point.getVector3fMap() += Eigen::Vector3f(1, -1, 0.5F);
  expectSameAsStockOrBetter(source, target, 5);
}
