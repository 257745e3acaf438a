// The tree that devices search: every point in one leaf, every leaf and node in its box, coincident points once.
#include "reference.h"
#include "search/box_tree.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <set>

namespace pcl_gpu_icp::test {

using namespace search;

namespace {

std::vector<PlacedPoint> placed(const Cloud& cloud) { return finitePoints(viewOf(cloud), {0, 0, 0}, 2); }

} // namespace

TEST(BoxTree, HoldsEveryPointOnceInsideItsBoxes)
{
  for (const std::size_t n : {1, 2, 15, 16, 17, 255, 256, 257, 4095, 4096, 4097, 40'000, 66'000}) {
    SCOPED_TRACE(n);
    Random random{unsigned(n)};
    const Cloud cloud = random.cloud(n);
    auto points = placed(cloud);
    sortIntoLeaves(points, 2);
    const TreeShape shape(points.size());
    std::vector<float> leaves(shape.leaves * LEAF_WORDS), nodes(shape.nodes * NODE_WORDS);
    writeLeaves(points, leaves.data());
    writeNodes(shape, leaves.data(), nodes.data(), 2);

    ASSERT_EQ(shape.leaves, (n + 15) / 16);
    ASSERT_EQ(shape.level_nodes[shape.root_level], 1U);
    std::vector<bool> seen(n);
    for (std::size_t i = 0; i < shape.leaves * LEAF_POINTS; ++i) {
      const float* words = &leaves[i / LEAF_POINTS * LEAF_WORDS + i % LEAF_POINTS];
      std::int32_t position;
      std::memcpy(&position, &words[3 * LEAF_POINTS], sizeof(position));
      if (i >= n) {
        EXPECT_EQ(position, -1);
        EXPECT_TRUE(std::isinf(words[0]));
        continue;
      }
      ASSERT_FALSE(seen.at(position));
      seen[position] = true;
      // In the boxes of its leaf and of every node above.
      for (std::size_t level = 0, child = i / LEAF_POINTS; level <= shape.root_level; ++level, child /= NODE_CHILDREN) {
        const float* node = &nodes[(shape.first_node[level] + child / NODE_CHILDREN) * NODE_WORDS];
        for (int axis = 0; axis < 3; ++axis) {
          const float x = words[axis * LEAF_POINTS];
          ASSERT_EQ(x, cloud(axis, position));
          ASSERT_LE(node[axis * NODE_CHILDREN + child % NODE_CHILDREN], x);
          ASSERT_GE(node[(3 + axis) * NODE_CHILDREN + child % NODE_CHILDREN], x);
        }
      }
    }
  }
}

TEST(BoxTree, DoesNotDependOnTheThreads)
{
  Random random(1);
  const Cloud cloud = random.cloud(70'000);
  auto alone = placed(cloud), together = alone;
  sortIntoLeaves(alone, 1);
  sortIntoLeaves(together, 4);
  // Within a leaf the order is free.
  for (std::size_t leaf = 0; leaf < alone.size(); leaf += LEAF_POINTS) {
    std::set<std::int32_t> a, b;
    for (std::size_t i = leaf; i < std::min(alone.size(), leaf + LEAF_POINTS); ++i) {
      a.insert(alone[i].position);
      b.insert(together[i].position);
    }
    ASSERT_EQ(a, b);
  }
}

TEST(BoxTree, OfCoincidentPointsTheFirstStays)
{
  Cloud cloud(3, 6);
  cloud << 1, 0, 1, -0.0F, 2, 1, //
      2, 0, 2, 0, 2, 2,          //
      3, 0, 3, 0, 2, 4;
  auto points = placed(cloud);
  dropCoincident(points);
  std::vector<std::int32_t> positions;
  for (const PlacedPoint& point : points)
    positions.push_back(point.position);
  EXPECT_EQ(positions, (std::vector<std::int32_t>{0, 1, 4, 5}));
}

TEST(BoxTree, LeavesNonFinitePointsOut)
{
  Random random(2);
  Cloud cloud = random.cloud(40);
  cloud(1, 3) = std::numeric_limits<float>::quiet_NaN();
  cloud(2, 17) = -std::numeric_limits<float>::infinity();
  const auto points = placed(cloud);
  EXPECT_EQ(points.size(), 38U);
  for (const PlacedPoint& point : points)
    EXPECT_TRUE(point.position != 3 && point.position != 17);
}

TEST(BoxTree, ManyCoincidentPointsAreNoQuadraticStep)
{
  // A million in one place: the tree over them, without the dropping, still takes well under a second.
  std::vector<PlacedPoint> points(1'000'000, PlacedPoint{{1, 2, 3}, 0});
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i].position = std::int32_t(i);
  auto distinct = points;
  dropCoincident(distinct);
  EXPECT_EQ(distinct.size(), 1U);
  sortIntoLeaves(points, 2);
  EXPECT_EQ(points.size(), 1'000'000U);
}

TEST(PivotOf, IsZeroNearTheOriginAndExactFarFromIt)
{
  Random random(3);
  EXPECT_EQ(pivotOf(viewOf(random.cloud(100, {10, 10, 10}, {5, 5, 5}))), (std::array<double, 3>{0, 0, 0}));
  const Cloud far = random.cloud(1000, {50, 50, 5}, {4e5, 5e6, 1});
  const auto pivot = pivotOf(viewOf(far));
  EXPECT_NEAR(pivot[0], 4e5, 60);
  EXPECT_NEAR(pivot[1], 5e6, 60);
  EXPECT_EQ(pivot[2], 0);
  for (const PlacedPoint& point : finitePoints(viewOf(far), pivot, 1))
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(pivot[axis] + point.xyz[axis], double(far(axis, point.position)));
}

} // namespace pcl_gpu_icp::test
