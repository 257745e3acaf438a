// The search method that IterativeClosestPoint installs is a pcl::search::KdTree to everybody else.
#include "scenes.h"

#include <pcl_gpu_icp/search/nearest_kdtree.h>

#include <gtest/gtest.h>

using pcl::PointXYZ;
using Cloud = pcl::PointCloud<PointXYZ>;
using Ours = pcl_gpu_icp::search::NearestKdTree<PointXYZ>;
using Stock = pcl::search::KdTree<PointXYZ>;

namespace {

void expectSameNeighbours(const pcl::search::Search<PointXYZ>& ours,
                          const pcl::search::Search<PointXYZ>& stock,
                          const Cloud& queries,
                          int k)
{
  pcl::Indices indices, stock_indices;
  std::vector<float> distances, stock_distances;
  for (const PointXYZ& query : queries) {
    ASSERT_EQ(ours.nearestKSearch(query, k, indices, distances),
              stock.nearestKSearch(query, k, stock_indices, stock_distances));
    ASSERT_EQ(distances, stock_distances);
    ASSERT_EQ(ours.radiusSearch(query, 0.1, indices, distances),
              stock.radiusSearch(query, 0.1, stock_indices, stock_distances));
    ASSERT_EQ(distances, stock_distances);
  }
}

} // namespace

TEST(NearestKdTree, AnswersAsPclDoes)
{
  const auto cloud = scenes::hills<PointXYZ>(1000);
  const auto queries = scenes::hills<PointXYZ>(200, 9);
  Ours ours;
  Stock stock;
  ours.setInputCloud(cloud);
  stock.setInputCloud(cloud);
  for (const int k : {1, 2, 10})
    expectSameNeighbours(ours, stock, *queries, k);
}

TEST(NearestKdTree, HonoursIndices)
{
  const auto cloud = scenes::hills<PointXYZ>(1000);
  pcl::IndicesPtr indices(new pcl::Indices);
  for (int i = 0; i < 1000; i += 7)
    indices->push_back(i);
  Ours ours;
  Stock stock;
  ours.setInputCloud(cloud, indices);
  stock.setInputCloud(cloud, indices);
  for (const int k : {1, 5})
    expectSameNeighbours(ours, stock, *scenes::hills<PointXYZ>(100, 9), k);
  pcl::Indices found;
  std::vector<float> distance;
  ASSERT_EQ(ours.nearestKSearch((*cloud)[7], 1, found, distance), 1);
  EXPECT_EQ(found[0], 7);
}

TEST(NearestKdTree, HonoursARepresentationSetLater)
{
  const auto cloud = scenes::hills<PointXYZ>(1000);
  pcl::DefaultPointRepresentation<PointXYZ>::Ptr flat(new pcl::DefaultPointRepresentation<PointXYZ>);
  const float scales[] = {1, 1, 0.01F};
  flat->setRescaleValues(scales);
  Ours ours;
  Stock stock;
  ours.setInputCloud(cloud);
  stock.setPointRepresentation(flat);
  stock.setInputCloud(cloud);
  ours.setPointRepresentation(flat);
  ours.refresh();
  EXPECT_EQ(ours.index(), nullptr);
  expectSameNeighbours(ours, stock, *scenes::hills<PointXYZ>(100, 9), 1);
}

TEST(NearestKdTree, NonFiniteQueriesFindNothing)
{
  Ours ours;
  ours.setInputCloud(scenes::hills<PointXYZ>(10));
  pcl::Indices found;
  std::vector<float> distance;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(ours.nearestKSearch(PointXYZ(nan, 0, 0), 1, found, distance), 0);
}
