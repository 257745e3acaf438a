#pragma once

#include "box_tree.h"

#include <vector>

namespace pcl_gpu_icp::search {

/// A tree of boxes on the host; see kernels/tree.h.
struct BoxTree {
  explicit BoxTree(const std::vector<PlacedPoint>& sorted, unsigned threads);

  TreeShape shape;
  std::vector<float> leaves, nodes;
};

/// A point found: its place in the leaves.
struct Found {
  float squared_distance;
  std::int32_t place;
};

/// The k points nearest to the query among those closer than `radius_sq`, or all of these where there are fewer;
/// nearest first. Of points as far as the last any may be left out.
std::vector<Found> nearestPoints(const BoxTree& tree, const float* query, std::size_t k, float radius_sq);

/// The points closer than `radius_sq`, in no order.
std::vector<Found> pointsWithin(const BoxTree& tree, const float* query, float radius_sq);

} // namespace pcl_gpu_icp::search
