// search::KdTree gives what pcl::search::KdTree gives: to itself, to PCL's classes, and on real scans.
#include "scans.h"
#include "search_parity.h"

#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/search/kdtree.h>

#include <algorithm>

using pcl::PointXYZ;
using Cloud = pcl::PointCloud<PointXYZ>;
using Ours = pcl_gpu_icp::search::KdTree<PointXYZ>;
using Stock = pcl::search::KdTree<PointXYZ>;

namespace {

const std::vector<int> ks = {1, 2, 7, 32};

void expectSameBatches(const Ours& ours, const Stock& stock, const Cloud& queries)
{
  for (const int k : ks) {
    std::vector<pcl::Indices> batch, stock_batch;
    std::vector<std::vector<float>> distances, stock_distances;
    ours.nearestKSearch(queries, pcl::Indices(), k, batch, distances);
    stock.nearestKSearch(queries, pcl::Indices(), k, stock_batch, stock_distances);
    ASSERT_EQ(distances, stock_distances);
    ASSERT_EQ(batch.size(), stock_batch.size());
    for (std::size_t i = 0; i < batch.size(); ++i)
      ASSERT_EQ(batch[i].size(), stock_batch[i].size());
  }
}

void expectSameAnswers(const Cloud::Ptr& cloud, const Cloud& queries, double radius)
{
  Ours ours;
  Stock stock;
  ours.setInputCloud(cloud);
  stock.setInputCloud(cloud);
  expectSameNeighbours(ours, stock, queries, ks, radius);
  expectSameBatches(ours, stock, queries);
}

Cloud everyNth(const Cloud& cloud, std::size_t n)
{
  Cloud some;
  for (std::size_t i = 0; i < cloud.size(); i += n)
    some.push_back(cloud[i]);
  return some;
}

} // namespace

TEST(KdTree, AnswersAsPclDoes)
{
  expectSameAnswers(scenes::hills<PointXYZ>(3000), *scenes::hills<PointXYZ>(300, 9), 0.1);
}

TEST(KdTree, OnEverySharedScan)
{
  if (!scans::areThere())
    GTEST_SKIP() << "no scans in " << scans::folder;
  for (const char* name : {"bunny_0.pcd", "lidar_street_0.pcd", "rgbd_room_0.pcd", "terrain_utm.pcd"}) {
    SCOPED_TRACE(name);
    const Cloud::Ptr cloud = scans::read(name);
    // Around the zero returns of a lidar thousands of points coincide; PCL's tree visits each of them.
    Cloud queries = everyNth(*cloud, cloud->size() / 150 + 1);
    for (PointXYZ& query : queries)
      query.x += 0.01F;
    expectSameAnswers(cloud, queries, 0.05);
  }
}

TEST(KdTree, HonoursIndices)
{
  expectIndicesHonoured<Ours>(ks, 0.3);
  const auto cloud = scenes::hills<PointXYZ>(1000);
  const pcl::IndicesPtr some(new pcl::Indices{3, 500, 17, 999});
  Ours ours;
  Stock stock;
  ours.setInputCloud(cloud, some);
  stock.setInputCloud(cloud, some);
  expectSameBatches(ours, stock, *scenes::hills<PointXYZ>(100, 9));
}

TEST(KdTree, BatchesOfSomePointsOfACloud)
{
  const auto cloud = scenes::hills<PointXYZ>(500);
  Ours ours;
  ours.setInputCloud(cloud);
  std::vector<pcl::Indices> found;
  std::vector<std::vector<float>> distances;
  ours.nearestKSearch(*cloud, {3, 400, 17}, 1, found, distances);
  EXPECT_EQ(found, (std::vector<pcl::Indices>{{3}, {400}, {17}}));
  EXPECT_EQ(distances, (std::vector<std::vector<float>>{{0}, {0}, {0}}));
}

TEST(KdTree, HonoursARepresentationSetBeforeOrAfter)
{
  const auto cloud = scenes::hills<PointXYZ>(1000);
  pcl::DefaultPointRepresentation<PointXYZ>::Ptr flat(new pcl::DefaultPointRepresentation<PointXYZ>);
  const float scales[] = {1, 1, 0.01F};
  flat->setRescaleValues(scales);
  Stock stock;
  stock.setPointRepresentation(flat);
  stock.setInputCloud(cloud);
  for (const bool before : {true, false}) {
    Ours ours;
    if (before)
      ours.setPointRepresentation(flat);
    ours.setInputCloud(cloud);
    if (!before)
      ours.setPointRepresentation(flat);
    const auto queries = scenes::hills<PointXYZ>(50, 9);
    expectSameNeighbours(ours, stock, *queries, ks, 0.3);
    expectSameBatches(ours, stock, *queries);
  }
}

TEST(KdTree, IsASearchMethodToPclsOwnAligner)
{
  const auto target = scenes::hills<PointXYZ>(1500);
  const auto source = scenes::moved(*scenes::hills<PointXYZ>(1200, 2), scenes::smallMotion());
  const auto align = [&](auto& icp, const Stock::Ptr& tree) {
    icp.setSearchMethodTarget(tree);
    icp.setInputSource(source);
    icp.setInputTarget(target);
    icp.setMaximumIterations(15);
    Cloud output;
    icp.align(output);
    return icp.getFinalTransformation();
  };
  pcl::IterativeClosestPoint<PointXYZ, PointXYZ> stock, with_our_tree;
  pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ> ours;
  const Eigen::Matrix4f expected = align(stock, pcl::make_shared<Stock>());
  EXPECT_EQ(align(with_our_tree, pcl::make_shared<Ours>()), expected);
  EXPECT_LT((align(ours, pcl::make_shared<Ours>()) - expected).norm(), 1e-5);
}
