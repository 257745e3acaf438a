// NearestIndex: the exact nearest point, checked against looking at every point.
#include "reference.h"

#include <pcl_gpu_icp/search/nearest_index.h>

#include <gtest/gtest.h>

#include <limits>
#include <thread>
#include <vector>

namespace pcl_gpu_icp::test {

using search::NearestIndex;
using search::Neighbour;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

Neighbour bruteForce(const Cloud& cloud, const float* query, float limit = infinity)
{
  Neighbour nearest;
  for (int i = 0; i < cloud.cols(); ++i) {
    const float distance = squaredDistance(cloud.col(i).data(), query);
    if (distance <= limit && distance < nearest.squared_distance)
      nearest = {i, distance};
  }
  return nearest;
}

NearestIndex indexOf(const Cloud& cloud)
{
  NearestIndex index;
  index.build(viewOf(cloud));
  return index;
}

/// Every query answered as by brute force: the same distance, and a point at that distance.
void expectExact(const Cloud& cloud, const Cloud& queries, float limit = infinity)
{
  const NearestIndex index = indexOf(cloud);
  for (int k = 0; k < queries.cols(); ++k) {
    const float* query = queries.col(k).data();
    const Neighbour expected = bruteForce(cloud, query, limit);
    const Neighbour found = index.nearest(query, limit);
    ASSERT_EQ(found.squared_distance, expected.squared_distance) << "query " << k;
    ASSERT_EQ(found.index < 0, expected.index < 0) << "query " << k;
    if (found.index >= 0) {
      ASSERT_EQ(squaredDistance(cloud.col(found.index).data(), query), expected.squared_distance) << "query " << k;
    }
  }
}

Cloud lattice(int side)
{
  Cloud cloud(3, side * side * side);
  for (int i = 0; i < cloud.cols(); ++i)
    cloud.col(i) = Eigen::Vector3f(float(i % side), float(i / side % side), float(i / side / side));
  return cloud;
}

} // namespace

TEST(NearestIndex, IsExactOnRandomClouds)
{
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Cloud cloud = random.cloud(random.count(1, 3000));
    expectExact(cloud, random.cloud(500));
    expectExact(cloud, random.cloud(100, {100, 100, 100}, {0, 0, 0}));
    expectExact(cloud, cloud);
  }
}

TEST(NearestIndex, IsExactWithinALimit)
{
  Random random(1);
  const Cloud cloud = random.cloud(2000), queries = random.cloud(500);
  for (const float limit : {0.0F, 1e-4F, 0.01F, 0.1F, 1.0F, 1e6F})
    expectExact(cloud, queries, limit);
}

TEST(NearestIndex, IsExactOnPlanes)
{
  for (int axis = 0; axis < 3; ++axis) {
    Random random(axis);
    Eigen::Vector3d extents(5, 5, 5);
    extents[axis] = 0;
    const Cloud cloud = random.cloud(3000, extents, {1, 2, 3});
    expectExact(cloud, random.cloud(300));
    expectExact(cloud, cloud.leftCols(300));
  }
}

TEST(NearestIndex, IsExactOnLines)
{
  Random random(4);
  for (const Eigen::Vector3d& extents : {Eigen::Vector3d(5, 0, 0), Eigen::Vector3d(0, 5, 0), Eigen::Vector3d(0, 0, 5)})
    expectExact(random.cloud(1000, extents, {0, 0, 0}), random.cloud(300));
  const Cloud oblique = moved(random.cloud(1000, {5, 0, 0}, {0, 0, 0}), random.motion(1));
  expectExact(oblique, random.cloud(300));
}

// Many points at the same distance, and queries on the planes that split the tree.
TEST(NearestIndex, IsExactOnALattice)
{
  const Cloud cloud = lattice(10);
  expectExact(cloud, cloud);
  expectExact(cloud, cloud.array() + 0.5F);
  expectExact(cloud, 0.5F * cloud);
  Random random(5);
  expectExact(cloud, random.cloud(300, {6, 6, 6}, {5, 5, 5}), 0.25F);
}

TEST(NearestIndex, IsExactFarFromTheOrigin)
{
  Random random(6);
  for (const double offset : {1e3, 5e5}) {
    SCOPED_TRACE(offset);
    const Eigen::Vector3d centre(offset, -offset, 10);
    expectExact(random.cloud(2000, {10, 10, 3}, centre), random.cloud(300, {10, 10, 3}, centre));
  }
}

TEST(NearestIndex, CountsCoincidentPointsOnceAndNamesTheFirst)
{
  Cloud cloud(3, 20'000);
  cloud.leftCols(10'000).colwise() = Eigen::Vector3f(1, 2, 3);
  cloud.rightCols(10'000).colwise() = Eigen::Vector3f(-4, 5, 6);
  const NearestIndex index = indexOf(cloud);
  EXPECT_EQ(index.size(), 2U);
  const float near_first[3] = {1, 2, 2}, near_second[3] = {-4, 5, 7};
  EXPECT_EQ(index.nearest(near_first).index, 0);
  EXPECT_EQ(index.nearest(near_second).index, 10'000);
  EXPECT_EQ(index.nearest(near_second).squared_distance, 1);
}

TEST(NearestIndex, CoincidentPointsAmongOthersDoNotHideThem)
{
  Random random(7);
  Cloud cloud = random.cloud(6000);
  for (int i = 0; i < 6000; i += 3)
    cloud.col(i).setZero();
  const NearestIndex index = indexOf(cloud);
  EXPECT_EQ(index.size(), 4001U);
  expectExact(cloud, random.cloud(300));
}

TEST(NearestIndex, ZeroAndMinusZeroAreOneCoordinate)
{
  Cloud cloud(3, 2);
  cloud << 0.0F, -0.0F, 1, 1, -0.0F, 0.0F;
  EXPECT_EQ(indexOf(cloud).size(), 1U);
}

TEST(NearestIndex, FindsWhatIsExactlyAtTheLimitAndNothingBeyond)
{
  const NearestIndex index = indexOf(Eigen::Vector3f(3, 0, 0));
  const float origin[3] = {0, 0, 0};
  EXPECT_EQ(index.nearest(origin, 9.0F).index, 0);
  EXPECT_EQ(index.nearest(origin, 9.0F).squared_distance, 9);
  EXPECT_EQ(index.nearest(origin, std::nextafter(9.0F, 0.0F)).index, -1);
  EXPECT_EQ(index.nearest(origin, std::nextafter(9.0F, 10.0F)).index, 0);
  const float there[3] = {3, 0, 0};
  EXPECT_EQ(index.nearest(there, 0.0F).index, 0);
  EXPECT_EQ(index.nearest(there, -1.0F).index, -1);
  EXPECT_EQ(index.nearest(there, not_a_number).index, -1);
  EXPECT_EQ(index.nearest(origin, std::numeric_limits<float>::max()).index, 0);
}

TEST(NearestIndex, ANeighbourhoodIsTheNearestFewAndNothingElseIsNearerThanItsBound)
{
  for (unsigned seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Cloud cloud = random.cloud(1000), queries = random.cloud(200);
    const NearestIndex index = indexOf(cloud);
    ASSERT_EQ(index.pivot(), (std::array<double, 3>{0, 0, 0}));
    for (int k = 0; k < queries.cols(); ++k) {
      const float* query = queries.col(k).data();
      const Neighbour nearest = bruteForce(cloud, query);
      for (const float slack : {0.0F, 0.3F, 2.0F, infinity})
        for (const unsigned kept : {1U, 2U, search::Neighbourhood::most})
          for (const float radius_sq : {infinity, nearest.squared_distance * 1.001F, nearest.squared_distance}) {
            const auto found = index.neighbourhood(query, radius_sq, slack, kept);
            if (radius_sq == nearest.squared_distance) {
              EXPECT_EQ(found.rows[0], -1) << "strictly closer than the radius";
              continue;
            }
            ASSERT_GE(found.rows[0], 0);
            EXPECT_EQ(index.points()[found.rows[0]].position, nearest.index);
            std::vector<bool> is_kept(1000);
            for (unsigned i = 0; i < kept && found.rows[i] >= 0; ++i) {
              is_kept[index.points()[found.rows[i]].position] = true;
              EXPECT_EQ(found.squared_distances[i],
                        squaredDistance(cloud.col(index.points()[found.rows[i]].position).data(), query));
              EXPECT_LE(found.squared_distances[i == 0 ? 0 : i - 1], found.squared_distances[i]);
            }
            for (int j = 0; j < cloud.cols(); ++j)
              if (!is_kept[j]) {
                ASSERT_GE(squaredDistance(cloud.col(j).data(), query), found.bound_sq * (1 - 1e-6F));
              }
          }
    }
  }
}

TEST(NearestIndex, QueriesThatAreNotFiniteFindNothing)
{
  Random random(8);
  const NearestIndex index = indexOf(random.cloud(100));
  for (const float bad : {not_a_number, infinity, -infinity})
    for (int axis = 0; axis < 3; ++axis) {
      float query[3] = {0, 0, 0};
      query[axis] = bad;
      EXPECT_EQ(index.nearest(query).index, -1);
    }
}

TEST(NearestIndex, PointsThatAreNotFiniteAreLeftOut)
{
  Random random(9);
  Cloud cloud = random.cloud(500);
  for (int i = 0; i < 500; i += 2)
    cloud(i % 3, i) = i % 4 ? not_a_number : infinity;
  const NearestIndex index = indexOf(cloud);
  EXPECT_EQ(index.size(), 250U);
  const Cloud queries = random.cloud(200);
  for (int k = 0; k < queries.cols(); ++k) {
    const Neighbour found = index.nearest(queries.col(k).data());
    EXPECT_EQ(found.index % 2, 1);
    EXPECT_EQ(found.squared_distance, bruteForce(cloud, queries.col(k).data()).squared_distance);
  }
}

TEST(NearestIndex, OfNothingFindsNothing)
{
  const float query[3] = {1, 2, 3};
  EXPECT_EQ(NearestIndex().nearest(query).index, -1);
  EXPECT_EQ(NearestIndex().size(), 0U);
  EXPECT_EQ(indexOf(Cloud(3, 0)).nearest(query).index, -1);
  EXPECT_EQ(indexOf(Cloud::Constant(3, 10, not_a_number)).nearest(query).index, -1);
}

TEST(NearestIndex, OfOnePointFindsIt)
{
  const float query[3] = {1e6F, 0, 0};
  EXPECT_EQ(indexOf(Eigen::Vector3f(1, 2, 3)).nearest(query).index, 0);
}

TEST(NearestIndex, AnswersWithThePositionThatAnIndexNames)
{
  Random random(10);
  const Cloud cloud = random.cloud(100);
  const std::vector<std::int32_t> chosen = {70, 3, 55, 3};
  Points points = viewOf(cloud);
  points.count = chosen.size();
  points.index = chosen.data();
  points.index_stride = sizeof(std::int32_t);
  NearestIndex index;
  index.build(points);
  EXPECT_EQ(index.size(), 3U);
  for (const std::int32_t i : chosen)
    EXPECT_EQ(index.nearest(cloud.col(i).data()).index, i);
}

TEST(NearestIndex, IsBuiltAnew)
{
  Random random(11);
  const Cloud first = random.cloud(100), second = random.cloud(50);
  NearestIndex index = indexOf(first);
  index.build(viewOf(second));
  EXPECT_EQ(index.size(), 50U);
  EXPECT_EQ(index.nearest(second.col(7).data()).index, 7);
  const NearestIndex other = std::move(index);
  EXPECT_EQ(other.nearest(second.col(8).data()).index, 8);
}

TEST(NearestIndex, AnswersSeveralThreads)
{
  Random random(12);
  const Cloud cloud = random.cloud(2000), queries = random.cloud(500);
  const NearestIndex index = indexOf(cloud);
  std::vector<int> wrong(4, 0);
  std::vector<std::thread> threads;
  for (int& count : wrong)
    threads.emplace_back([&] {
      for (int k = 0; k < queries.cols(); ++k)
        count += index.nearest(queries.col(k).data()).index == bruteForce(cloud, queries.col(k).data()).index ? 0 : 1;
    });
  for (std::thread& thread : threads)
    thread.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST(Fingerprint, ChangesWithACoordinateTheNumberAndTheOrder)
{
  Random random(13);
  const Cloud cloud = random.cloud(100);
  const auto fingerprint = search::fingerprintOf(viewOf(cloud));
  EXPECT_EQ(search::fingerprintOf(viewOf(Cloud(cloud))), fingerprint);
  EXPECT_NE(search::fingerprintOf(viewOf(cloud.leftCols(99))), fingerprint);
  EXPECT_NE(search::fingerprintOf(viewOf(cloud.rowwise().reverse())), fingerprint);
  for (int i = 0; i < 300; ++i) {
    Cloud changed = cloud;
    changed(i % 3, i / 3) = std::nextafter(changed(i % 3, i / 3), 100.0F);
    EXPECT_NE(search::fingerprintOf(viewOf(changed)), fingerprint);
  }
}

} // namespace pcl_gpu_icp::test
