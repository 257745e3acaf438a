#pragma once

#include "scenes.h"

#include <pcl/search/kdtree.h>

#include <gtest/gtest.h>

#include <vector>

// Search methods of this library against pcl::search::KdTree: the same distances, to the bit. Of points equally far
// either may be found.

using Search = pcl::search::Search<pcl::PointXYZ>;

inline void expectSameNeighbours(const Search& ours,
                                 const Search& stock,
                                 const pcl::PointCloud<pcl::PointXYZ>& queries,
                                 const std::vector<int>& ks,
                                 double radius)
{
  pcl::Indices indices, stock_indices;
  std::vector<float> distances, stock_distances;
  for (const pcl::PointXYZ& query : queries) {
    for (const int k : ks) {
      ASSERT_EQ(ours.nearestKSearch(query, k, indices, distances),
                stock.nearestKSearch(query, k, stock_indices, stock_distances));
      ASSERT_EQ(distances, stock_distances);
    }
    for (const unsigned most : {0, 3}) {
      ASSERT_EQ(ours.radiusSearch(query, radius, indices, distances, most),
                stock.radiusSearch(query, radius, stock_indices, stock_distances, most));
      ASSERT_EQ(distances, stock_distances);
    }
  }
}

/// A tree over every seventh point names it by its place in the whole cloud.
template <typename Ours>
void expectIndicesHonoured(const std::vector<int>& ks, double radius)
{
  const auto cloud = scenes::hills<pcl::PointXYZ>(1000);
  pcl::IndicesPtr indices(new pcl::Indices);
  for (int i = 0; i < 1000; i += 7)
    indices->push_back(i);
  Ours ours;
  pcl::search::KdTree<pcl::PointXYZ> stock;
  ours.setInputCloud(cloud, indices);
  stock.setInputCloud(cloud, indices);
  expectSameNeighbours(ours, stock, *scenes::hills<pcl::PointXYZ>(100, 9), ks, radius);
  pcl::Indices found;
  std::vector<float> distance;
  ASSERT_EQ(ours.nearestKSearch((*cloud)[7], 1, found, distance), 1);
  EXPECT_EQ(found[0], 7);
}
