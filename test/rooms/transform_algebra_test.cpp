// The arithmetic of rigid transforms in double precision, and how they are rounded when they are handed out.
#include "reference.h"

#include <gtest/gtest.h>

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

TEST(RigidTransform, ComposesFirstThenSecond)
{
  Random random(1);
  const Isometry3d first = random.motion(5), second = random.motion(5);
  const Isometry3d both = isometryOf(compose(transformOf(second), transformOf(first)));
  EXPECT_TRUE(both.isApprox(second * first, 1e-15));
}

TEST(RigidTransform, ItsInverseTakesItBack)
{
  Random random(2);
  const Isometry3d motion = random.motion(5);
  EXPECT_TRUE(isometryOf(inverse(transformOf(motion))).isApprox(motion.inverse(), 1e-15));
}

TEST(RigidTransform, MapsAPoint)
{
  Random random(3);
  const Isometry3d motion = random.motion(5);
  EXPECT_TRUE(vectorOf(transformOf(motion)(1, 2, 3)).isApprox(motion * Vector3d(1, 2, 3), 1e-15));
}

TEST(RigidTransform, RecentredIsTheSameMotionAboutOtherOrigins)
{
  Random random(4);
  const Isometry3d motion = random.motion(5);
  const Vector3d from(100, 200, 300), to(-40, 50, 60), x(101, 199, 305);
  const auto about = recentred(transformOf(motion), arrayOf(from), arrayOf(to));
  const Vector3d local = x - from;
  EXPECT_TRUE(vectorOf(about(local.x(), local.y(), local.z())).isApprox(motion * x - to, 1e-13));
}

// R and t rounded apart are off by R's rounding times the distance from the origin.
TEST(RigidTransform, IsRigidUnlessScaledMirroredOrNotFinite)
{
  const RigidTransform rigid = transformOf(motion({1, 2, 3}, 2, {4, 5, 6}));
  EXPECT_TRUE(isRigid(rigid));
  const auto changed = [&](auto change) {
    RigidTransform transform = rigid;
    change(transform);
    return isRigid(transform);
  };
  EXPECT_TRUE(changed([](RigidTransform& t) { t.rotation[0] += 4e-4; }));
  EXPECT_FALSE(changed([](RigidTransform& t) { t.rotation[0] += 4e-3; }));
  EXPECT_FALSE(changed([](RigidTransform& t) {
    for (double& entry : t.rotation)
      entry *= 1.001;
  }));
  EXPECT_FALSE(changed([](RigidTransform& t) {
    for (double& entry : t.rotation)
      entry = -entry;
  }));
  EXPECT_FALSE(changed([](RigidTransform& t) { t.rotation[4] = std::nan(""); }));
  EXPECT_FALSE(changed([](RigidTransform& t) { t.translation[2] = HUGE_VAL; }));
}

TEST(RigidTransform, TheNearestRotationIsOneToTheLastDigitsAndKeepsTheAnchor)
{
  for (const double off : {0.0, 1e-7, 1e-4, 4e-4}) {
    RigidTransform transform = transformOf(motion({1, 2, 3}, 2, {4, 5, 6}));
    transform.rotation[1] += off;
    transform.rotation[5] -= off;
    const RigidTransform nearest = nearestRigid(transform, {7, 8, 9});
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        double product = i == j ? -1 : 0;
        for (int k = 0; k < 3; ++k)
          product += nearest.rotation[3 * i + k] * nearest.rotation[3 * j + k];
        EXPECT_NEAR(product, 0, 5e-16);
        EXPECT_NEAR(nearest.rotation[3 * i + j], transform.rotation[3 * i + j], off + 1e-15);
      }
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(nearest(7, 8, 9)[axis], transform(7, 8, 9)[axis], 1e-14);
  }
  EXPECT_EQ(nearestRigid({}, {7, 8, 9}).rotation, RigidTransform().rotation);
}

TEST(RigidTransform, RoundedStillMapsItsAnchorWhereItShould)
{
  for (const double distance : {0.0, 1e2, 1e4, 5e5}) {
    SCOPED_TRACE(distance);
    Random random(5);
    Isometry3d motion = random.motion(1);
    const Vector3d anchor(distance, -distance, 10);
    motion.translation() += anchor - motion.linear() * anchor;
    const auto together = isometryOf(rounded<float>(transformOf(motion), arrayOf(anchor)));
    const Eigen::Matrix4f in_float = together.matrix().cast<float>();
    EXPECT_EQ(Eigen::Matrix4d(in_float.cast<double>()), together.matrix()) << "representable in float";
    const double ulp = std::max(1.0, motion.translation().cwiseAbs().maxCoeff()) * 6e-8;
    EXPECT_LE((together * anchor - motion * anchor).cwiseAbs().maxCoeff(), ulp);
    const Isometry3d exact = isometryOf(rounded<double>(transformOf(motion), arrayOf(anchor)));
    EXPECT_EQ(exact.linear(), motion.linear());
    EXPECT_LE((exact * anchor - motion * anchor).norm(), 1e-9);
  }
}

} // namespace pcl_gpu_icp::test
