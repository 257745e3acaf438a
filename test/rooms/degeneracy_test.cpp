// Geometry that leaves something undetermined: a defined transform and a named verdict, and never NaN.
#include "estimator_cases.h"

#include <pcl_gpu_icp/error.h>

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// n points on the line through `centre` along `direction`.
Cloud line(Random& random, std::size_t n, const Vector3d& centre, const Vector3d& direction)
{
  Cloud cloud(3, n);
  for (std::size_t i = 0; i < n; ++i)
    cloud.col(i) = (centre + random.uniform(-5, 5) * direction).cast<float>();
  return cloud;
}

Cloud cube()
{
  Cloud corners(3, 8);
  for (int i = 0; i < 8; ++i)
    corners.col(i) = Eigen::Vector3f(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  return corners;
}

double angleOf(const Matrix3d& R) { return Eigen::AngleAxisd(R).angle(); }

} // namespace

class Degenerate : public WithEstimator {
protected:
  Isometry3d solve(const Cloud& source, const Cloud& target, Degeneracy expected)
  {
    const Estimate result = estimate(source, target);
    EXPECT_EQ(toString(result.degeneracy), std::string(toString(expected)));
    expectRigid(result, isDouble() ? 1e-12 : 1e-6);
    return isometryOf(result.transform);
  }
};

TEST_P(Degenerate, NothingIsTheIdentity)
{
  EXPECT_EQ(solve(Cloud(3, 0), Cloud(3, 0), Degeneracy::Empty).matrix(), Isometry3d::Identity().matrix());
}

TEST_P(Degenerate, OnePairIsATranslation)
{
  const Isometry3d result = solve(Eigen::Vector3f(1, 2, 3), Eigen::Vector3f(-4, 5, 7), Degeneracy::Point);
  EXPECT_EQ(result.linear(), Matrix3d::Identity());
  EXPECT_EQ(result.translation(), Vector3d(-5, 3, 4));
}

TEST_P(Degenerate, CoincidentPointsAreATranslation)
{
  for (const std::size_t n : {std::size_t(2), std::size_t(3), std::size_t(100), device().affordable(5000)}) {
    SCOPED_TRACE(n);
    for (const float far : {0.0F, 1.0F, 1e3F, 5e5F}) {
      SCOPED_TRACE(far);
      const Cloud source = Eigen::Vector3f(far + 0.1F, -far, 3.3F).replicate(1, n);
      const Cloud target = Eigen::Vector3f(7, far, 0.7F).replicate(1, n);
      const Isometry3d result = solve(source, target, Degeneracy::Point);
      EXPECT_EQ(result.linear(), Matrix3d::Identity());
      EXPECT_LE(rmsResidual(result, source, target), 1e-9 * (1 + far));
    }
  }
}

TEST_P(Degenerate, ASpreadOnOneSideOnlyIsATranslation)
{
  Random random(1);
  const Cloud spread = random.cloud(200), point = Eigen::Vector3f(1, 2, 3).replicate(1, 200);
  for (const auto& [source, target] : {std::pair(spread, point), std::pair(point, spread)}) {
    const Isometry3d result = solve(source, target, Degeneracy::Point);
    EXPECT_EQ(result.linear(), Matrix3d::Identity());
    EXPECT_LE(
        (result * referenceOf(source, target).source_centroid - referenceOf(source, target).target_centroid).norm(),
        1e-5);
  }
}

TEST_P(Degenerate, TwoPairsAreALine)
{
  Cloud source(3, 2), target(3, 2);
  source << 0, 1, 0, 0, 0, 0;
  target << 5, 5, 0, 2, 0, 0;
  const Isometry3d result = solve(source, target, Degeneracy::Line);
  EXPECT_LE((result.linear() * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-6);
  EXPECT_NEAR(angleOf(result.linear()), EIGEN_PI / 2, 1e-6);
  EXPECT_LE((result * Vector3d(0.5, 0, 0) - Vector3d(5, 1, 0)).norm(), 1e-6);
}

TEST_P(Degenerate, ALineTurnsByTheSmallestAngle)
{
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const std::size_t n = random.count(2, device().affordable(3000));
    const Vector3d from = random.direction(), to = random.direction();
    const Cloud source = line(random, n, random.direction(), from);
    const Isometry3d turn = motion(from.cross(to), std::acos(from.dot(to)), {1, 2, 3});
    const Isometry3d result = solve(source, moved(source, turn), Degeneracy::Line);
    EXPECT_LE(rmsDifference(result, turn, source), 5e-6);
    EXPECT_LE((result.linear() - turn.linear()).cwiseAbs().maxCoeff(), 2e-5) << "no turn about the line";
  }
}

TEST_P(Degenerate, ALineAlongAnAxis)
{
  for (int axis = 0; axis < 3; ++axis) {
    Random random(axis);
    const Cloud source = line(random, device().affordable(500), Vector3d::Zero(), Vector3d::Unit(axis));
    EXPECT_LE((solve(source, source, Degeneracy::Line).linear() - Matrix3d::Identity()).norm(), 1e-6);
  }
}

TEST_P(Degenerate, AReversedLineIsHalfATurnAcrossIt)
{
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Vector3d direction = seed <= 3 ? Vector3d(Vector3d::Unit(seed - 1)) : random.direction();
    const Cloud source = line(random, device().affordable(1000), Vector3d::Zero(), direction);
    const Cloud target = -source;
    const Isometry3d result = solve(source, target, Degeneracy::Line);
    EXPECT_LE(rmsResidual(result, source, target), 5e-6);
    EXPECT_NEAR(angleOf(result.linear()), EIGEN_PI, 1e-3);
  }
}

TEST_P(Degenerate, ALineFarFromTheOriginIsStillALine)
{
  for (const double offset : {100.0, 1e4, 5e5}) {
    SCOPED_TRACE(offset);
    Random random(3);
    const Cloud source = line(random, device().affordable(2000), Vector3d(offset, -offset, 10), random.direction());
    const Cloud target = moved(source, motion({0, 0, 1}, 0.1, {1, 2, 3}));
    solve(source, target, Degeneracy::Line);
    solve(source, source, Degeneracy::Line);
  }
}

TEST_P(Degenerate, ThreePairsAndAPlaneDetermineEverything)
{
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const std::size_t n = seed <= 4 ? 3 : random.count(4, device().affordable(3000));
    Cloud source = random.cloud(n, {8, 5, 0}, {0, 0, 0});
    if (n == 3)
      source << 0, 4, 1, 0, 0, 3, 0, 0, 0;
    source = moved(source, random.motion(5));
    const Isometry3d truth = random.motion(5);
    EXPECT_LE(rmsDifference(solve(source, moved(source, truth), Degeneracy::None), truth, source), 1e-5);
  }
}

TEST_P(Degenerate, AMirroredTargetGivesARotation)
{
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Cloud source = random.cloud(random.count(4, device().affordable(500)));
    Cloud target = moved(source, random.motion(3));
    target.row(seed % 3) *= -1;
    const Isometry3d result = solve(source, target, Degeneracy::None);
    const Reference expected = referenceOf(source, target);
    EXPECT_LE((result.linear() - expected.R).cwiseAbs().maxCoeff(), 1e-4);
    Isometry3d best = Isometry3d::Identity();
    best.linear() = expected.R;
    best.translation() = expected.t;
    EXPECT_NEAR(rmsResidual(result, source, target), rmsResidual(best, source, target), 1e-5);
  }
}

TEST_P(Degenerate, EqualSingularValuesAreNoObstacle)
{
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Cloud source = cube();
    const Isometry3d truth = random.motion(3);
    EXPECT_LE(rmsDifference(solve(source, moved(source, truth), Degeneracy::None), truth, source), 2e-6);
    // Mirrored, every direction is as good as any to reflect along: the residual is what counts.
    Cloud mirrored = source;
    mirrored.row(0) *= -1;
    mirrored = moved(mirrored, truth);
    const Isometry3d result = solve(source, mirrored, Degeneracy::None);
    const Reference expected = referenceOf(source, mirrored);
    Isometry3d best = Isometry3d::Identity();
    best.linear() = expected.R;
    best.translation() = expected.t;
    EXPECT_NEAR(rmsResidual(result, source, mirrored), rmsResidual(best, source, mirrored), 2e-6);
  }
}

TEST_P(Degenerate, ASphereIsNoObstacle)
{
  Random random(5);
  Cloud source(3, device().affordable(2000));
  for (int i = 0; i < source.cols(); ++i)
    source.col(i) = random.direction().cast<float>();
  const Isometry3d truth = random.motion(3);
  EXPECT_LE(rmsDifference(solve(source, moved(source, truth), Degeneracy::None), truth, source), 2e-6);
}

TEST_P(Degenerate, HalfATurnIsFound)
{
  Random random(6);
  const Cloud source = random.cloud(device().affordable(300));
  for (const Vector3d& axis : {Vector3d(1, 0, 0),
                               Vector3d(0, 1, 0),
                               Vector3d(0, 0, 1),
                               Vector3d(1, 1, 0),
                               Vector3d(1, 1, 1),
                               Vector3d(1, -2, 3),
                               Vector3d(random.direction())}) {
    SCOPED_TRACE(testing::Message() << "about " << axis.transpose());
    const Isometry3d truth = motion(axis, EIGEN_PI, {1, 2, 3});
    EXPECT_LE(rmsDifference(solve(source, moved(source, truth), Degeneracy::None), truth, source), 1e-5);
    EXPECT_LE(rmsDifference(solve(cube(), moved(cube(), truth), Degeneracy::None), truth, cube()), 1e-5);
  }
}

TEST_P(Degenerate, UncorrelatedCloudsStillGiveARotation)
{
  Random random(7);
  for (const std::size_t n : {std::size_t(3), std::size_t(4), std::size_t(100), device().affordable(5000)})
    solve(random.cloud(n), random.cloud(n), Degeneracy::None);
}

// Products vanish in float32 below 1e-38.
TEST_P(Degenerate, TinyCloudsNeverGiveNaN)
{
  Random random(8);
  const Cloud unit = random.cloud(100);
  for (const float scale : {1e-40F, 1e-37F, 1e-30F, 1e-25F, 1e-22F, 1e-20F, 1e-19F, 1e-18F, 1e-15F}) {
    SCOPED_TRACE(scale);
    const Cloud source = unit * scale;
    expectRigid(estimate(source, moved(source, motion({1, 2, 3}, 1, {0, 0, 0}))), 1e-6);
  }
}

// Products leave float32 above 1e38.
TEST_P(Degenerate, HugeCloudsAreSolvedOrRefused)
{
  Random random(9);
  const Cloud unit = random.cloud(100);
  for (const float scale : {1e10F, 1e15F, 1e17F, 1e18F, 1e19F, 1e25F}) {
    SCOPED_TRACE(scale);
    const Cloud source = unit * scale;
    const Isometry3d truth = motion({1, 2, 3}, 1, {0, 0, 0});
    try {
      const Estimate result = estimate(source, moved(source, truth));
      EXPECT_LE(rmsDifference(isometryOf(result.transform), truth, source), 1e-5 * scale);
    } catch (const InvalidArgument& error) {
      EXPECT_FALSE(isDouble());
      EXPECT_GE(scale, 1e17F);
      EXPECT_NE(std::string(error.what()).find("too large"), std::string::npos) << error.what();
    }
  }
}

RUN_EVERY_KERNEL_ESTIMATOR(Degenerate);

} // namespace pcl_gpu_icp::test
