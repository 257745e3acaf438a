// What lies around a few places of a cloud, checked against looking at every point.
#include "search/surroundings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace pcl_gpu_icp::test {
namespace {

using search::foundAround;
using search::Nearby;
using search::Surroundings;
using Places = std::vector<std::array<double, 3>>;

std::vector<PlacedPoint> anyCloud(std::size_t count, float size, unsigned seed)
{
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> place(-size, size);
  std::vector<PlacedPoint> cloud(count);
  for (PlacedPoint& point : cloud)
    for (float& x : point.xyz)
      x = place(generator);
  return cloud;
}

Places placesIn(const std::vector<PlacedPoint>& cloud)
{
  Places places;
  for (const PlacedPoint& point : cloud)
    places.push_back({point.xyz[0], point.xyz[1], point.xyz[2]});
  return places;
}

Surroundings byLookingAtAll(const std::array<double, 3>& place, const std::vector<PlacedPoint>& cloud, double radius)
{
  Surroundings found;
  for (const PlacedPoint& point : cloud) {
    const std::array<double, 3> v{point.xyz[0] - place[0], point.xyz[1] - place[1], point.xyz[2] - place[2]};
    const double squared = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (squared <= radius * radius)
      found.add({v[0] / radius, v[1] / radius, v[2] / radius}, squared);
  }
  return found;
}

TEST(Surroundings, AreThoseOfLookingAtEveryPoint)
{
  const auto cloud = anyCloud(20000, 1, 1);
  for (const float size : {1.0F, 1.5F}) { // some of the places are off the cloud
    const Places places = placesIn(anyCloud(200, size, 2));
    for (const double radius : {0.02, 0.1, 0.4, 3.0}) {
      SCOPED_TRACE(radius);
      const auto found = foundAround<Surroundings>(places, cloud, radius, 2);
      const auto nearby = foundAround<Nearby>(places, cloud, radius, 2);
      ASSERT_EQ(found.size(), places.size());
      for (std::size_t i = 0; i < places.size(); ++i) {
        const Surroundings expected = byLookingAtAll(places[i], cloud, radius);
        EXPECT_EQ(found[i].count, expected.count);
        EXPECT_EQ(nearby[i].count, expected.count);
        EXPECT_EQ(found[i].nearest_sq, expected.nearest_sq);
        EXPECT_EQ(nearby[i].nearest_sq, expected.nearest_sq);
        for (std::size_t k = 0; k < 3; ++k)
          EXPECT_NEAR(found[i].sum[k], expected.sum[k], 1e-9 * static_cast<double>(1 + expected.count));
        for (std::size_t k = 0; k < 6; ++k)
          EXPECT_NEAR(found[i].squares[k], expected.squares[k], 1e-9 * static_cast<double>(1 + expected.count));
      }
    }
  }
}

TEST(Surroundings, HaveTheSameBitsForAnyNumberOfThreads)
{
  const auto cloud = anyCloud(30000, 1, 3);
  const Places places = placesIn(anyCloud(100, 1, 4));
  const auto one = foundAround<Surroundings>(places, cloud, 0.2, 1);
  for (const unsigned threads : {2U, 5U}) {
    const auto several = foundAround<Surroundings>(places, cloud, 0.2, threads);
    for (std::size_t i = 0; i < places.size(); ++i) {
      EXPECT_EQ(several[i].sum, one[i].sum);
      EXPECT_EQ(several[i].squares, one[i].squares);
    }
  }
}

TEST(Surroundings, AreEmptyFarAwayAndWithoutARadius)
{
  auto cloud = anyCloud(100, 1, 5);
  cloud[0].xyz[0] = 1e18F;
  for (const double radius : {1e-12, 0.0, std::nan("")})
    for (const Nearby& around : foundAround<Nearby>({{2, 2, 2}, {1e18, 0, 0}}, cloud, radius, 1))
      EXPECT_EQ(around.count, 0U);
  EXPECT_TRUE(foundAround<Nearby>({}, cloud, 1, 1).empty());
  EXPECT_EQ(foundAround<Nearby>({{0, 0, 0}}, {}, 1, 1)[0].count, 0U);
}

} // namespace
} // namespace pcl_gpu_icp::test
