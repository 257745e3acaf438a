// Matcher and parallelFor: the same correspondences from any number of threads, and those that brute force finds.
#include "reference.h"

#include <pcl_gpu_icp/parallel_for.h>
#include <pcl_gpu_icp/search/matcher.h>

#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <stdexcept>

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using search::Matcher;
using search::NearestIndex;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

std::pair<int, float> nearestIn(const Cloud& cloud, const Eigen::Vector3f& query)
{
  Eigen::Index nearest = 0;
  const float distance = (cloud.colwise() - query).colwise().squaredNorm().minCoeff(&nearest);
  return {int(nearest), distance};
}

bool same(const std::vector<Correspondence>& a, const std::vector<Correspondence>& b)
{
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Correspondence& x, const Correspondence& y) {
    return x.source == y.source && x.target == y.target && x.squared_distance == y.squared_distance;
  });
}

} // namespace

TEST(Matcher, FindsTheNearestTargetOfEverySourcePointIterationAfterIteration)
{
  Random random(1);
  const Cloud source = random.cloud(500), target = random.cloud(800);
  NearestIndex index;
  index.build(viewOf(target));
  for (const float limit : {0.3F, infinity}) {
    Matcher matcher(viewOf(source), viewOf(target), index, limit, 2);
    for (int iteration = 0; iteration < 5; ++iteration) {
      const Isometry3d pose = motion({0, 0, 1}, 0.02 * iteration, {0.1 * iteration, 0, 0});
      const auto& found = matcher.match(transformOf(pose));
      const Cloud at_pose = moved(source, pose);
      std::size_t k = 0;
      for (int i = 0; i < source.cols(); ++i) {
        const auto [nearest, distance] = nearestIn(target, at_pose.col(i));
        if (distance > limit)
          continue;
        ASSERT_LT(k, found.size());
        EXPECT_EQ(found[k].source, i);
        EXPECT_EQ(found[k].target, nearest);
        EXPECT_FLOAT_EQ(found[k].squared_distance, distance);
        ++k;
      }
      EXPECT_EQ(k, found.size());
    }
  }
}

TEST(Matcher, KeepsOnlyMutualNeighboursWhenAsked)
{
  Random random(2);
  const Cloud source = random.cloud(300), target = random.cloud(200);
  NearestIndex index;
  index.build(viewOf(target));
  Matcher matcher(viewOf(source), viewOf(target), index, infinity, 2);
  matcher.requireReciprocal();
  const Isometry3d pose = motion({0, 1, 0}, 0.1, {0.2, 0, 0});
  const auto& found = matcher.match(transformOf(pose));
  const Cloud at_pose = moved(source, pose);
  std::vector<std::pair<int, int>> expected, pairs;
  for (int i = 0; i < source.cols(); ++i) {
    const int nearest = nearestIn(target, at_pose.col(i)).first;
    if (nearestIn(at_pose, target.col(nearest)).first == i)
      expected.emplace_back(i, nearest);
  }
  for (const Correspondence& c : found)
    pairs.emplace_back(c.source, c.target);
  EXPECT_EQ(pairs, expected);
}

TEST(Matcher, LeavesNonFiniteSourcePointsOut)
{
  Random random(3);
  Cloud source = random.cloud(50);
  source(1, 7) = std::numeric_limits<float>::quiet_NaN();
  NearestIndex index;
  index.build(viewOf(source));
  Matcher matcher(viewOf(source), viewOf(source), index, infinity, 1);
  const auto& found = matcher.match({});
  ASSERT_EQ(found.size(), 49U);
  for (const Correspondence& c : found) {
    EXPECT_EQ(c.source, c.target);
    EXPECT_NE(c.source, 7);
  }
}

TEST(Matcher, AnswersTheSameFromAnyNumberOfThreads)
{
  Random random(4);
  const Cloud source = random.cloud(5000), target = random.cloud(3000);
  NearestIndex index;
  index.build(viewOf(target));
  Matcher alone(viewOf(source), viewOf(target), index, infinity, 1);
  const auto expected = alone.match({});
  for (const unsigned threads : {2, 3, 8}) {
    Matcher matcher(viewOf(source), viewOf(target), index, infinity, threads);
    EXPECT_TRUE(same(matcher.match({}), expected)) << threads;
    EXPECT_TRUE(same(matcher.match({}), expected)) << threads << ", started from the neighbours before";
  }
}

TEST(RootMeanSquareDistance, IsThatOfTheCorrespondences)
{
  Cloud source(3, 2), target(3, 2);
  source << 0, 1, 0, 0, 0, 0;
  target << 3, 1, 0, 0, 0, 1;
  EXPECT_DOUBLE_EQ(search::rootMeanSquareDistance({{0, 0, 0}, {1, 1, 0}}, viewOf(source), viewOf(target), {}),
                   std::sqrt((9.0 + 1.0) / 2));
  EXPECT_EQ(search::rootMeanSquareDistance({}, viewOf(source), viewOf(target), {}), 0);
}

TEST(ParallelFor, CoversEveryIndexOnce)
{
  for (const std::size_t count : {0, 1, 511, 512, 513, 5000})
    for (const unsigned threads : {0, 1, 2, 7}) {
      std::vector<std::atomic<int>> visits(count);
      parallelFor(count, 512, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
          ++visits[i];
      });
      for (std::size_t i = 0; i < count; ++i)
        ASSERT_EQ(visits[i], 1) << i << " of " << count;
    }
}

TEST(ParallelFor, RethrowsWhatABodyThrows)
{
  for (const unsigned threads : {1, 4})
    EXPECT_THROW(parallelFor(10'000,
                             512,
                             threads,
                             [](std::size_t begin, std::size_t) {
                               if (begin > 4000)
                                 throw std::runtime_error("from a body");
                             }),
                 std::runtime_error);
}

} // namespace pcl_gpu_icp::test
