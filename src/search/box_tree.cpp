#include "box_tree.h"

#include "bulk.h"
#include "select.h"

#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>

namespace pcl_gpu_icp::search {

namespace {

constexpr std::size_t points_at_a_time = 16384; ///< for a host thread
constexpr float infinity = std::numeric_limits<float>::infinity();

struct Box {
  float low[3] = {infinity, infinity, infinity};
  float high[3] = {-infinity, -infinity, -infinity};

  void include(const float* xyz)
  {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], xyz[axis]);
      high[axis] = std::max(high[axis], xyz[axis]);
    }
  }
};

/// x, y and z in one register, and something else.
using Coordinates = float __attribute__((vector_size(4 * sizeof(float))));

Coordinates coordinatesOf(const PlacedPoint& point)
{
  static_assert(sizeof(PlacedPoint) == sizeof(Coordinates));
  Coordinates coordinates;
  std::memcpy(&coordinates, &point, sizeof(coordinates));
  return coordinates;
}

/// Of the points' box.
int longestSide(const PlacedPoint* first, const PlacedPoint* last)
{
  Coordinates low = coordinatesOf(*first), high = low;
  for (const PlacedPoint* point = first + 1; point != last; ++point) {
    const Coordinates here = coordinatesOf(*point);
    low = here < low ? here : low;
    high = here > high ? here : high;
  }
  const Coordinates sides = high - low;
  const int of_x_and_y = sides[1] > sides[0] ? 1 : 0;
  return sides[2] > sides[of_x_and_y] ? 2 : of_x_and_y;
}

/// Sorts [first, last) into subtrees of `subtree` points each (the last may have fewer), then each of them.
void split(PlacedPoint* first, PlacedPoint* last, std::size_t subtree, unsigned threads)
{
  while (last - first > LEAF_POINTS) {
    const auto count = static_cast<std::size_t>(last - first);
    while (subtree >= count)
      subtree = std::max<std::size_t>(subtree / NODE_CHILDREN, 1);
    const std::size_t subtrees = (count + subtree - 1) / subtree;
    PlacedPoint* middle = first + subtrees / 2 * subtree;
    selectAlong(longestSide(first, last), first, middle, last);
    if (threads > 1 && count > points_at_a_time) {
      std::thread half(split, first, middle, subtree, threads / 2);
      split(middle, last, subtree, threads - threads / 2);
      half.join();
      return;
    }
    split(first, middle, subtree, 1);
    first = middle;
  }
}

} // namespace

std::array<double, 3> pivotOf(const Points& points)
{
  const auto samples = samplesOf(points);
  const Bulk bulk(samples);
  std::array<double, 3> pivot{};
  for (int axis = 0; axis < 3; ++axis) {
    const double median = bulk.median()[axis];
    double low = median, high = median;
    for (const float* sample : samples)
      if (bulk.holds(sample)) {
        low = std::min<double>(low, sample[axis]);
        high = std::max<double>(high, sample[axis]);
      }
    if (std::abs(median) > 2 * (high - low))
      pivot[axis] = median;
  }
  return pivot;
}

std::vector<PlacedPoint> finitePoints(const Points& points, const std::array<double, 3>& pivot, unsigned threads)
{
  const float x = static_cast<float>(pivot[0]), y = static_cast<float>(pivot[1]), z = static_cast<float>(pivot[2]);
  constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
  std::vector<PlacedPoint> placed(points.count);
  parallelFor(points.count, points_at_a_time, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const float* p = points[i];
      // -0 and 0 are one coordinate.
      placed[i] = {{p[0] - x + 0.0F, p[1] - y + 0.0F, p[2] - z + 0.0F}, static_cast<std::int32_t>(points.position(i))};
      if (!takesPart(p))
        placed[i].xyz[0] = not_a_number;
    }
  });
  const auto is_left_out = [](const PlacedPoint& p) { return std::isnan(p.xyz[0]); };
  placed.erase(std::remove_if(placed.begin(), placed.end(), is_left_out), placed.end());
  return placed;
}

std::uint64_t hashOf(const float* xyz)
{
  std::uint32_t bits[3];
  std::memcpy(bits, xyz, sizeof(bits));
  std::uint64_t hash = 0;
  for (const std::uint32_t word : bits) {
    hash = (hash ^ word) * 0x9E3779B97F4A7C15ULL;
    hash ^= hash >> 32;
  }
  return hash;
}

void dropCoincident(std::vector<PlacedPoint>& points)
{
  // Open addressing; a slot holds the place of a point that stays.
  std::size_t slots = 16;
  while (slots < 2 * points.size())
    slots *= 2;
  std::vector<std::int32_t> held(slots, -1);
  std::size_t kept = 0;
  for (const PlacedPoint& point : points) {
    std::size_t slot = hashOf(point.xyz) & (slots - 1);
    while (held[slot] >= 0 && !std::equal(point.xyz, point.xyz + 3, points[held[slot]].xyz))
      slot = (slot + 1) & (slots - 1);
    if (held[slot] >= 0)
      continue;
    held[slot] = static_cast<std::int32_t>(kept);
    points[kept++] = point;
  }
  points.resize(kept);
}

void sortIntoLeaves(std::vector<PlacedPoint>& points, unsigned threads)
{
  std::size_t subtree = LEAF_POINTS;
  while (subtree < points.size())
    subtree *= NODE_CHILDREN;
  split(points.data(), points.data() + points.size(), subtree, threads);
}

TreeShape::TreeShape(std::size_t points)
: leaves(std::max<std::size_t>(1, (points + LEAF_POINTS - 1) / LEAF_POINTS))
{
  for (std::size_t below = leaves;; ++root_level) {
    below = (below + NODE_CHILDREN - 1) / NODE_CHILDREN;
    first_node[root_level] = static_cast<std::uint32_t>(nodes);
    level_nodes[root_level] = static_cast<std::uint32_t>(below);
    nodes += below;
    if (below <= 1)
      return;
  }
}

void writeLeaves(const std::vector<PlacedPoint>& sorted, float* leaves)
{
  const std::size_t padded = TreeShape(sorted.size()).leaves * LEAF_POINTS;
  const PlacedPoint unused{{infinity, infinity, infinity}, -1};
  for (std::size_t i = 0; i < padded; ++i) {
    const PlacedPoint& point = i < sorted.size() ? sorted[i] : unused;
    float* words = leaves + i / LEAF_POINTS * LEAF_WORDS + i % LEAF_POINTS;
    for (std::size_t axis = 0; axis < 3; ++axis)
      words[axis * LEAF_POINTS] = point.xyz[axis];
    std::memcpy(&words[std::size_t(3) * LEAF_POINTS], &point.position, sizeof(point.position));
  }
}

float spacingOf(const std::vector<PlacedPoint>& sorted)
{
  constexpr std::size_t samples_at_most = 255;
  const std::size_t leaves = sorted.size() / LEAF_POINTS;
  std::vector<float> diagonals;
  for (std::size_t leaf = 0; leaf < leaves; leaf += leaves / samples_at_most + 1) {
    Box box;
    for (std::size_t i = 0; i < LEAF_POINTS; ++i)
      box.include(sorted[leaf * LEAF_POINTS + i].xyz);
    diagonals.push_back(std::hypot(box.high[0] - box.low[0], box.high[1] - box.low[1], box.high[2] - box.low[2]));
  }
  if (diagonals.empty())
    return 0;
  const auto middle = diagonals.begin() + diagonals.size() / 2;
  std::nth_element(diagonals.begin(), middle, diagonals.end());
  // Points of a surface: four by four in a leaf.
  return *middle / 5;
}

void writeNodes(const TreeShape& shape, const float* leaves, float* nodes, unsigned threads)
{
  const auto put = [](float* node, std::size_t child, const Box& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      node[axis * NODE_CHILDREN + child] = box.low[axis];
      node[(3 + axis) * NODE_CHILDREN + child] = box.high[axis];
    }
  };
  const auto leaf_box = [&](std::size_t leaf) {
    Box box;
    for (std::size_t i = 0; leaf < shape.leaves && i < LEAF_POINTS; ++i) {
      const float* words = leaves + leaf * LEAF_WORDS + i;
      const float xyz[] = {words[0], words[LEAF_POINTS], words[std::size_t(2) * LEAF_POINTS]};
      if (std::isfinite(xyz[0]))
        box.include(xyz);
    }
    return box;
  };
  const auto node_box = [&](std::uint32_t level, std::size_t index) {
    Box box;
    if (index >= shape.level_nodes[level])
      return box;
    const float* node = nodes + (shape.first_node[level] + index) * NODE_WORDS;
    for (std::size_t child = 0; child < NODE_CHILDREN; ++child)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = std::min(box.low[axis], node[axis * NODE_CHILDREN + child]);
        box.high[axis] = std::max(box.high[axis], node[(3 + axis) * NODE_CHILDREN + child]);
      }
    return box;
  };
  for (std::uint32_t level = 0; level <= shape.root_level; ++level)
    parallelFor(shape.level_nodes[level], 64, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t node = begin; node < end; ++node)
        for (std::size_t child = 0; child < NODE_CHILDREN; ++child) {
          const std::size_t below = node * NODE_CHILDREN + child;
          put(nodes + (shape.first_node[level] + node) * NODE_WORDS,
              child,
              level == 0 ? leaf_box(below) : node_box(level - 1, below));
        }
    });
}

} // namespace pcl_gpu_icp::search
