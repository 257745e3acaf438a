#include "box_tree_query.h"

#include <algorithm>
#include <array>

namespace pcl_gpu_icp::search {

namespace {

float outside(float x, float low, float high) { return std::max(std::max(low - x, x - high), 0.0F); }

std::array<float, NODE_CHILDREN> childDistances(const float* node, const float* query)
{
  std::array<float, NODE_CHILDREN> distances{};
  for (int axis = 0; axis < 3; ++axis)
    for (int child = 0; child < NODE_CHILDREN; ++child) {
      const float d =
          outside(query[axis], node[axis * NODE_CHILDREN + child], node[(3 + axis) * NODE_CHILDREN + child]);
      distances[child] += d * d;
    }
  return distances;
}

/// Shows `visit` every point that may be closer than the radius that it returns, near ones first.
template <typename Visit>
void walk(
    const BoxTree& tree, const float* query, std::uint32_t level, std::size_t node, float& radius_sq, Visit& visit)
{
  const auto distances = childDistances(&tree.nodes[(tree.shape.first_node[level] + node) * NODE_WORDS], query);
  std::array<int, NODE_CHILDREN> order{};
  int near = 0;
  for (int child = 0; child < NODE_CHILDREN; ++child)
    if (distances[child] < radius_sq)
      order[near++] = child;
  std::sort(order.begin(), order.begin() + near, [&](int a, int b) { return distances[a] < distances[b]; });
  for (int i = 0; i < near && distances[order[i]] < radius_sq; ++i) {
    const std::size_t child = node * NODE_CHILDREN + static_cast<std::size_t>(order[i]);
    if (level > 0) {
      walk(tree, query, level - 1, child, radius_sq, visit);
      continue;
    }
    const float* points = &tree.leaves[child * LEAF_WORDS];
    for (int lane = 0; lane < LEAF_POINTS; ++lane) {
      const float x = query[0] - points[lane], y = query[1] - points[LEAF_POINTS + lane],
                  z = query[2] - points[2 * LEAF_POINTS + lane];
      const float distance_sq = x * x + y * y + z * z;
      if (distance_sq < radius_sq)
        radius_sq = visit({distance_sq, static_cast<std::int32_t>(child * LEAF_POINTS) + lane});
    }
  }
}

bool isNearer(const Found& a, const Found& b) { return a.squared_distance < b.squared_distance; }

} // namespace

BoxTree::BoxTree(const std::vector<PlacedPoint>& sorted, unsigned threads)
: shape(sorted.size())
, leaves(shape.leaves * LEAF_WORDS)
, nodes(shape.nodes * NODE_WORDS)
{
  writeLeaves(sorted, leaves.data());
  writeNodes(shape, leaves.data(), nodes.data(), threads);
}

std::vector<Found> nearestPoints(const BoxTree& tree, const float* query, std::size_t k, float radius_sq)
{
  std::vector<Found> heap; // the farthest first
  if (k == 0)
    return heap;
  const float limit_sq = radius_sq;
  auto keep = [&](const Found& found) {
    if (heap.size() == k) {
      std::pop_heap(heap.begin(), heap.end(), isNearer);
      heap.back() = found;
    }
    else
      heap.push_back(found);
    std::push_heap(heap.begin(), heap.end(), isNearer);
    return heap.size() == k ? heap.front().squared_distance : limit_sq;
  };
  walk(tree, query, tree.shape.root_level, 0, radius_sq, keep);
  std::sort_heap(heap.begin(), heap.end(), isNearer);
  return heap;
}

std::vector<Found> pointsWithin(const BoxTree& tree, const float* query, float radius_sq)
{
  std::vector<Found> found;
  auto keep = [&](const Found& point) {
    found.push_back(point);
    return radius_sq;
  };
  float limit_sq = radius_sq;
  walk(tree, query, tree.shape.root_level, 0, limit_sq, keep);
  return found;
}

} // namespace pcl_gpu_icp::search
