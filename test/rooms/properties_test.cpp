// What holds of every estimate, over random cases whose seeds are printed.
#include "estimator_cases.h"

#include <algorithm>
#include <numeric>

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Noisy pairs of a random motion, on a lattice: differences of coordinates are exact.
struct Pairs {
  Cloud source, target;
};

Pairs randomPairs(unsigned seed, std::size_t most)
{
  Random random(seed);
  const std::size_t n = random.count(4, most);
  Pairs pairs;
  pairs.source = snapped(random.cloud(n, {6, 4, 2}, {1, -1, 0.5}));
  pairs.target = snapped(moved(pairs.source, random.motion(2)) + random.cloud(n, {0.1, 0.1, 0.1}, {0, 0, 0}));
  return pairs;
}

} // namespace

class Property : public WithEstimator {
protected:
  template <typename Claim>
  void forRandomPairs(const Claim& claim)
  {
    // Few and small where the device is slow.
    const unsigned cases = device().mostPoints() < 1000 ? 3 : 20;
    for (unsigned seed = 100; seed < 100 + cases; ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed);
      claim(seed, randomPairs(seed, device().affordable(400)));
    }
  }

  /// Of rotations; translations are within about 10 m.
  double tolerance() const { return 300 * device().epsilon(); }
};

TEST_P(Property, EveryRotationIsProper)
{
  forRandomPairs([&](unsigned, const Pairs& pairs) {
    const Estimate result = estimate(pairs.source, pairs.target);
    expectRigid(result, isDouble() ? 1e-12 : 1e-6);
    const Matrix3d R = matrixOf(result.stages.R);
    EXPECT_LE((R.transpose() * R - Matrix3d::Identity()).cwiseAbs().maxCoeff(), isDouble() ? 1e-12 : 1e-6);
    EXPECT_NEAR(R.determinant(), 1, isDouble() ? 1e-12 : 1e-6);
  });
}

TEST_P(Property, HIsUSV)
{
  forRandomPairs([&](unsigned, const Pairs& pairs) {
    const StageValues stages = estimate(pairs.source, pairs.target).stages;
    const Matrix3d H = matrixOf(stages.H), U = matrixOf(stages.U), V = matrixOf(stages.V);
    const Vector3d S = vectorOf(stages.S);
    const double epsilon = 16 * device().epsilon();
    EXPECT_LE((U * S.asDiagonal() * V.transpose() - H).norm(), epsilon * H.norm());
    EXPECT_LE((U.transpose() * U - Matrix3d::Identity()).norm(), epsilon);
    EXPECT_LE((V.transpose() * V - Matrix3d::Identity()).norm(), epsilon);
    EXPECT_GE(S[0], S[1]);
    EXPECT_GE(S[1], S[2]);
    EXPECT_GE(S[2], 0);
  });
}

TEST_P(Property, TheOrderOfThePairsDoesNotMatter)
{
  forRandomPairs([&](unsigned seed, const Pairs& pairs) {
    std::vector<int> order(pairs.source.cols());
    std::iota(order.begin(), order.end(), 0);
    Random random(seed);
    std::shuffle(order.begin(), order.end(), random.generator());
    const Estimate before = estimate(pairs.source, pairs.target);
    const Estimate after = estimate(pairs.source(Eigen::all, order), pairs.target(Eigen::all, order));
    EXPECT_LE((matrixOf(after.transform.rotation) - matrixOf(before.transform.rotation)).norm(), tolerance());
    EXPECT_LE((vectorOf(after.transform.translation) - vectorOf(before.transform.translation)).norm(),
              10 * tolerance());
  });
}

// M T M^-1, when M moves both clouds. A quarter turn and whole metres keep the coordinates on the lattice.
TEST_P(Property, MovingBothCloudsMovesTheEstimate)
{
  forRandomPairs([&](unsigned seed, const Pairs& pairs) {
    Random random(seed);
    Isometry3d move = Isometry3d::Identity();
    move.linear() = Eigen::AngleAxisd(EIGEN_PI / 2, Vector3d::Unit(random.count(0, 2))).toRotationMatrix();
    move.linear() = move.linear().array().round();
    move.translation() = Vector3d(random.count(0, 9), random.count(0, 9), random.count(0, 9));
    const Isometry3d before = isometryOf(estimate(pairs.source, pairs.target).transform);
    const Isometry3d after = isometryOf(estimate(moved(pairs.source, move), moved(pairs.target, move)).transform);
    const Isometry3d expected = move * before * move.inverse();
    EXPECT_LE((after.linear() - expected.linear()).norm(), tolerance());
    EXPECT_LE((after.translation() - expected.translation()).norm(), 20 * tolerance());
  });
}

TEST_P(Property, SwappingTheCloudsGivesTheInverse)
{
  forRandomPairs([&](unsigned, const Pairs& pairs) {
    const Isometry3d there = isometryOf(estimate(pairs.source, pairs.target).transform);
    const Isometry3d back = isometryOf(estimate(pairs.target, pairs.source).transform);
    EXPECT_LE((there * back).matrix().operator-(Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff(), 20 * tolerance());
  });
}

TEST_P(Property, TheSamePairsGiveTheSameBits)
{
  RigidEstimator other = GetParam().estimator();
  forRandomPairs([&](unsigned seed, const Pairs& pairs) {
    const Estimate first = estimate(pairs.source, pairs.target);
    const Pairs between = randomPairs(seed + 1000, device().affordable(400));
    estimate(between.source, between.target);
    EXPECT_TRUE(identical(estimate(pairs.source, pairs.target), first)) << "from run to run";
    EXPECT_TRUE(identical(other.estimate(viewOf(pairs.source), viewOf(pairs.target)), first)) << "elsewhere";
  });
}

TEST_P(Property, ManyPairsGiveTheSameBitsEveryTime)
{
  Random random(1);
  const std::size_t n = device().affordable(50'000);
  const Cloud source = random.cloud(n), target = random.cloud(n);
  const Estimate first = estimate(source, target);
  for (int run = 0; run < 5; ++run)
    EXPECT_TRUE(identical(estimate(source, target), first));
}

TEST_P(Property, APairsPlaceInItsCloudDoesNotMatter)
{
  forRandomPairs([&](unsigned, const Pairs& pairs) {
    // The same pairs through an index into a larger cloud.
    const int n = pairs.source.cols();
    Cloud wide(3, 2 * n);
    std::vector<std::int32_t> odd(n);
    for (int i = 0; i < n; ++i) {
      wide.col(2 * i).setConstant(1e9F);
      wide.col(2 * i + 1) = pairs.source.col(i);
      odd[i] = 2 * i + 1;
    }
    Points source = viewOf(wide);
    source.count = odd.size();
    source.index = odd.data();
    source.index_stride = sizeof(std::int32_t);
    EXPECT_TRUE(identical(estimator_.estimate(source, viewOf(pairs.target)), estimate(pairs.source, pairs.target)));
  });
}

RUN_EVERY_KERNEL_ESTIMATOR(Property);

} // namespace pcl_gpu_icp::test
