// The search method that IterativeClosestPoint installs is a pcl::search::KdTree to everybody else.
#include "search_parity.h"

#include <pcl_gpu_icp/search/nearest_kdtree.h>

using pcl::PointXYZ;
using Ours = pcl_gpu_icp::search::NearestKdTree<PointXYZ>;
using Stock = pcl::search::KdTree<PointXYZ>;

TEST(NearestKdTree, AnswersAsPclDoes)
{
  const auto cloud = scenes::hills<PointXYZ>(1000);
  const auto queries = scenes::hills<PointXYZ>(200, 9);
  Ours ours;
  Stock stock;
  ours.setInputCloud(cloud);
  stock.setInputCloud(cloud);
  expectSameNeighbours(ours, stock, *queries, {1, 2, 10}, 0.1);
}

TEST(NearestKdTree, HonoursIndices) { expectIndicesHonoured<Ours>({1, 5}, 0.1); }

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
  expectSameNeighbours(ours, stock, *scenes::hills<PointXYZ>(100, 9), {1}, 0.1);
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
