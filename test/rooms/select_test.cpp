// The selection that halves clouds: on either side lies what std::nth_element puts there, whatever the points are.
#include "reference.h"
#include "search/select.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace pcl_gpu_icp::test {

namespace {

std::vector<std::int32_t> sortedPositions(std::vector<PlacedPoint>::const_iterator first,
                                          std::vector<PlacedPoint>::const_iterator last)
{
  std::vector<std::int32_t> positions;
  std::transform(first, last, std::back_inserter(positions), [](const PlacedPoint& point) { return point.position; });
  std::sort(positions.begin(), positions.end());
  return positions;
}

void expectSelected(const std::vector<PlacedPoint>& points, int axis, std::size_t nth)
{
  auto expected = points, found = points;
  std::nth_element(expected.begin(), expected.begin() + nth, expected.end(), [axis](const auto& a, const auto& b) {
    return a.xyz[axis] < b.xyz[axis] || (a.xyz[axis] == b.xyz[axis] && a.position < b.position);
  });
  search::selectAlong(axis, found.data(), found.data() + nth, found.data() + found.size());
  ASSERT_EQ(found[nth].position, expected[nth].position);
  ASSERT_EQ(sortedPositions(found.begin(), found.begin() + nth),
            sortedPositions(expected.begin(), expected.begin() + nth));
  ASSERT_EQ(sortedPositions(found.begin() + nth, found.end()), sortedPositions(expected.begin() + nth, expected.end()));
}

template <typename Coordinate>
std::vector<PlacedPoint> pointsAt(std::size_t n, int axis, Coordinate coordinate)
{
  std::vector<PlacedPoint> points(n);
  for (std::size_t i = 0; i < n; ++i) {
    points[i].xyz[axis] = coordinate(i);
    points[i].position = static_cast<std::int32_t>(i);
  }
  return points;
}

} // namespace

TEST(SelectAlong, PutsOnEitherSideWhatBelongsThere)
{
  for (const std::size_t n : {1, 2, 10, 11, 12, 100, 599, 600, 601, 8191, 8192, 20'000})
    for (int axis = 0; axis < 3; ++axis) {
      Random random(static_cast<unsigned>(n));
      const Cloud cloud = random.cloud(n);
      const auto of = [&](const auto& coordinate) { return pointsAt(n, axis, coordinate); };
      const std::vector<std::vector<PlacedPoint>> clouds{
          of([&](std::size_t i) { return cloud(0, i); }),
          of([](std::size_t i) { return static_cast<float>(i); }),
          of([](std::size_t i) { return -static_cast<float>(i); }),
          of([](std::size_t) { return 1.5F; }),
          of([](std::size_t i) { return static_cast<float>(i % 3) - 1; }),
          of([](std::size_t i) { return static_cast<float>(i % 160); }), // rows of a depth image
          of([&](std::size_t i) { return i == 7 ? 1e30F : 1e-40F * cloud(0, i); })};
      for (std::size_t which = 0; which < clouds.size(); ++which)
        for (const std::size_t nth : {std::size_t{0}, n / 7, n / 2, n - 1 - n / 9, n - 1}) {
          SCOPED_TRACE(std::to_string(n) + " points of kind " + std::to_string(which) + ", " + std::to_string(nth));
          expectSelected(clouds[which], axis, nth);
        }
    }
}

TEST(SelectAlong, ThePointsThatAreOneInAllAreNoHindrance)
{
  std::vector<PlacedPoint> points(1000, PlacedPoint{{1, 2, 3}, 4});
  points[500].xyz[1] = 1;
  search::selectAlong(1, points.data(), points.data() + 300, points.data() + points.size());
  EXPECT_EQ(points[0].xyz[1], 1);
  EXPECT_EQ(points[300].xyz[1], 2);
}

} // namespace pcl_gpu_icp::test
