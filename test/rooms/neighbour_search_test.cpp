// NeighbourSearch: the k nearest and those within a radius, compared with looking at every point; batches on every
// device and kernel shape.
#include "device_cases.h"
#include "engine/neighbour_search_internals.h"
#include "reference.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_gpu_icp::test {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

std::vector<float> sortedDistances(const Cloud& cloud, const float* query)
{
  std::vector<float> distances;
  for (int i = 0; i < cloud.cols(); ++i)
    if (cloud.col(i).allFinite())
      distances.push_back(squaredDistance(query, cloud.col(i).data()));
  std::sort(distances.begin(), distances.end());
  return distances;
}

void expectNearest(const Neighbours& found, const Cloud& cloud, const float* query, std::size_t k)
{
  auto expected = sortedDistances(cloud, query);
  expected.resize(std::min(k, expected.size()));
  ASSERT_EQ(found.squared_distances, expected);
  ASSERT_EQ(found.positions.size(), expected.size());
  std::vector<std::int32_t> once = found.positions;
  std::sort(once.begin(), once.end());
  ASSERT_EQ(std::unique(once.begin(), once.end()), once.end());
  for (std::size_t i = 0; i < expected.size(); ++i)
    ASSERT_EQ(squaredDistance(query, cloud.col(found.positions[i]).data()), expected[i]);
}

/// Random, planar, collinear, coincident, lattice, with strays, far from the origin.
std::vector<Cloud> clouds(std::size_t n)
{
  Random random(1);
  Cloud lattice = random.cloud(n, {3.4, 3.4, 1.4}, {0, 0, 0}).array().round().matrix();
  Cloud strays = random.cloud(n);
  for (int i = 0; i < strays.cols(); i += 5)
    strays(i % 3, i) = i % 2 ? not_a_number : infinity;
  return {random.cloud(n),
          random.cloud(n, {5, 5, 0}, {0, 0, 1}),
          random.cloud(n, {5, 0, 0}, {0, 0, 1}),
          random.cloud(n, {0, 0, 0}, {1, 2, 3}),
          lattice,
          strays,
          random.cloud(n, {50, 50, 5}, {4e5, 5e6, 100})};
}

} // namespace

class NeighbourSearching : public OnDevice {
protected:
  NeighbourSearch search_{makeNeighbourSearch(GetParam().device, GetParam().traits)};
};

TEST_P(NeighbourSearching, BatchesFindTheNearest)
{
  const bool few = GetParam().isEmulated(); // each launch takes it a fifth of a second
  for (const std::size_t n : few ? std::vector<std::size_t>{7, 300} : std::vector<std::size_t>{1, 7, 100, 300}) {
    int kind = 0;
    for (const Cloud& cloud : clouds(n)) {
      SCOPED_TRACE("cloud " + std::to_string(kind++) + " of " + std::to_string(n));
      search_.build(viewOf(cloud));
      Cloud queries = cloud.leftCols(std::min<Eigen::Index>(cloud.cols(), 40));
      for (int i = 0; i < queries.cols(); i += 2)
        queries.col(i) += Eigen::Vector3f(0.25F, -0.5F, 0.125F);
      for (const std::size_t k :
           few ? std::vector<std::size_t>{2, 32} : std::vector<std::size_t>{1, 2, 5, 16, 32, 33}) {
        const auto found = search_.nearest(viewOf(queries), k);
        ASSERT_EQ(found.size(), std::size_t(queries.cols()));
        for (int i = 0; i < queries.cols(); ++i) {
          if (queries.col(i).allFinite())
            expectNearest(found[i], cloud, queries.col(i).data(), k);
          else
            ASSERT_TRUE(found[i].positions.empty());
          if (HasFatalFailure())
            return;
        }
      }
    }
  }
}

TEST_P(NeighbourSearching, EverySizeOfABatch)
{
  Random random(2);
  const Cloud cloud = random.cloud(1000);
  search_.build(viewOf(cloud));
  for (const std::size_t n : {0, 1, 15, 16, 17, 255, 256, 257, 600}) {
    const Cloud queries = random.cloud(n);
    const auto found = search_.nearest(viewOf(queries), 3);
    ASSERT_EQ(found.size(), n);
    for (std::size_t i = 0; i < n; ++i)
      expectNearest(found[i], cloud, queries.col(Eigen::Index(i)).data(), 3);
  }
}

RUN_WITH_EVERY_SEARCH(NeighbourSearching);

TEST(NeighbourSearch, SingleQueriesFindTheNearestAndThoseWithinARadius)
{
  for (const std::size_t n : {1, 7, 100, 3000}) {
    int kind = 0;
    for (const Cloud& cloud : clouds(n)) {
      SCOPED_TRACE("cloud " + std::to_string(kind++) + " of " + std::to_string(n));
      NeighbourSearch search;
      search.build(viewOf(cloud));
      for (int i = 0; i < cloud.cols(); i += 1 + int(n) / 20) {
        if (!cloud.col(i).allFinite())
          continue;
        const Eigen::Vector3f query = cloud.col(i) + Eigen::Vector3f(0.25F, 0, 0.125F);
        for (const std::size_t k : {1, 4, 50})
          expectNearest(search.nearest(query.data(), k), cloud, query.data(), k);
        for (const double radius : {0.0, 0.3, 1.0, 100.0}) {
          auto expected = sortedDistances(cloud, query.data());
          expected.erase(std::lower_bound(expected.begin(), expected.end(), float(radius * radius)), expected.end());
          EXPECT_EQ(search.within(query.data(), radius).squared_distances, expected);
          EXPECT_EQ(search.within(query.data(), radius, 0, false).positions.size(), expected.size());
          expected.resize(std::min<std::size_t>(expected.size(), 3));
          EXPECT_EQ(search.within(query.data(), radius, 3).squared_distances, expected);
        }
      }
    }
  }
}

TEST(NeighbourSearch, NothingToFindIsNotAnError)
{
  NeighbourSearch search;
  const float origin[3] = {0, 0, 0}, stray[3] = {0, not_a_number, 0};
  EXPECT_TRUE(search.nearest(origin, 1).positions.empty());
  search.build({});
  EXPECT_EQ(search.size(), 0U);
  EXPECT_TRUE(search.nearest(origin, 1).positions.empty());
  EXPECT_TRUE(search.within(origin, 1).positions.empty());
  Random random(3);
  const Cloud cloud = random.cloud(5);
  search.build(viewOf(cloud));
  EXPECT_TRUE(search.nearest(stray, 1).positions.empty());
  EXPECT_TRUE(search.within(stray, 1).positions.empty());
  EXPECT_TRUE(search.nearest(origin, 0).positions.empty());
}

} // namespace pcl_gpu_icp::test
