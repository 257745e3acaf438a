#pragma once

#include "kernels/layout.h"

#include <pcl_gpu_icp/points.h>

#include <array>
#include <cstdint>
#include <vector>

namespace pcl_gpu_icp::search {

/// Where a cloud's coordinates are kept about, so that float32 keeps its digits far from the origin: the median of a
/// few points on an axis on which the cloud is farther from 0 than its own extent, where subtracting it is exact
/// (Sterbenz 1974), and 0 on the others. A few points far from all others do not count.
std::array<double, 3> pivotOf(const Points& points);

/// The points that take part, less `pivot` (float32 values).
std::vector<PlacedPoint> finitePoints(const Points& points, const std::array<double, 3>& pivot, unsigned threads);

/// Of the bits of three coordinates.
std::uint64_t hashOf(const float* xyz);

/// Leaves out every point that coincides with an earlier one.
void dropCoincident(std::vector<PlacedPoint>& points);

/// Brings the points into the order of the tree's leaves: halved again and again across the longest side of their box,
/// at multiples of what a subtree holds.
void sortIntoLeaves(std::vector<PlacedPoint>& points, unsigned threads);

/// The sizes of the tree over n points; see kernels/tree.h. Over none it has one leaf without points.
struct TreeShape {
  explicit TreeShape(std::size_t points);

  std::size_t leaves;
  std::size_t nodes = 0;
  std::array<std::uint32_t, TREE_LEVELS> first_node{}; ///< of each level, the lowest first
  std::array<std::uint32_t, TREE_LEVELS> level_nodes{};
  std::uint32_t root_level = 0;
};

/// Writes sorted points as LEAF_WORDS words for each leaf.
void writeLeaves(const std::vector<PlacedPoint>& sorted, float* leaves);

/// The typical distance between neighbouring points of sorted points; 0 when there are too few to tell.
float spacingOf(const std::vector<PlacedPoint>& sorted);

/// Writes the boxes over the leaves as NODE_WORDS words for each node.
void writeNodes(const TreeShape& shape, const float* leaves, float* nodes, unsigned threads);

} // namespace pcl_gpu_icp::search
