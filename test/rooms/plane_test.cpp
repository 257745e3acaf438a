// Point-to-plane increments: those of a double reference, from listed pairs and from matches, on every device, kernel
// shape and precision; free motions are named and left as they were.
#include "device_cases.h"
#include "engine/matcher_internals.h"
#include "engine/plane_estimator_internals.h"
#include "reference.h"

#include <pcl_gpu_icp/error.h>

#include <Eigen/QR>

#include <cmath>
#include <limits>

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// The least-squares motion in double, through the 6 n equations themselves and not their squares.
Isometry3d planeReferenceOf(const Cloud& source, const Cloud& target, const Cloud& normals)
{
  const Eigen::Matrix3Xd p = source.cast<double>(), q = target.cast<double>(), n = normals.cast<double>();
  const Vector3d centre = p.rowwise().mean();
  Eigen::MatrixXd J(p.cols(), 6);
  Eigen::VectorXd r(p.cols());
  for (int i = 0; i < p.cols(); ++i) {
    J.row(i) << Vector3d(p.col(i) - centre).cross(Vector3d(n.col(i))).transpose(), n.col(i).transpose();
    r[i] = n.col(i).dot(q.col(i) - p.col(i));
  }
  const Vector6d x = J.colPivHouseholderQr().solve(r);
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(x[2], Vector3d::UnitZ()) * Eigen::AngleAxisd(x[1], Vector3d::UnitY()) *
                             Eigen::AngleAxisd(x[0], Vector3d::UnitX()))
                                .toRotationMatrix();
  Isometry3d motion = Isometry3d::Identity();
  motion.linear() = R;
  motion.translation() = centre + x.tail<3>() - R * centre;
  return motion;
}

/// Points of an ellipsoid, which holds every motion fast, with their normals.
struct Surface {
  Cloud points, normals;
};
Surface ellipsoid(Random& random, std::size_t n, const Vector3d& half_axes, const Vector3d& centre)
{
  Surface surface{Cloud(3, n), Cloud(3, n)};
  for (int i = 0; i < surface.points.cols(); ++i) {
    const Vector3d u = random.direction();
    surface.points.col(i) = (u.cwiseProduct(half_axes) + centre).cast<float>();
    surface.normals.col(i) = u.cwiseQuotient(half_axes).normalized().cast<float>();
  }
  return surface;
}

} // namespace

class PlaneStage : public OnDevice {
protected:
  Estimate estimate(const Cloud& source, const Cloud& target, const Cloud& normals)
  {
    return estimator_.estimate(viewOf(source), viewOf(target), viewOf(normals));
  }
  bool isDouble() const { return GetParam().precision == Precision::Double; }

  PlaneEstimator estimator_{makePlaneEstimator(GetParam().device, GetParam().traits, GetParam().precision)};
};

TEST_P(PlaneStage, IncrementIsThatOfTheReferenceForEverySize)
{
  for (const std::size_t n : GetParam().sizes(20'000)) {
    if (n < 12)
      continue;
    SCOPED_TRACE("seed " + std::to_string(n));
    Random random(static_cast<unsigned>(n));
    const Cloud target = random.cloud(n), normals = random.directions(n);
    Cloud source = moved(target, motion(random.direction(), 0.02, random.direction() * 0.1));
    for (int i = 0; i < source.cols(); ++i)
      source.col(i) += (random.direction() * 0.05).cast<float>();
    const Estimate found = estimate(source, target, normals);
    EXPECT_EQ(found.pairs, n);
    EXPECT_EQ(found.degeneracy, Degeneracy::None);
    EXPECT_LT(rmsDifference(isometryOf(found.transform), planeReferenceOf(source, target, normals), source),
              isDouble() ? 1e-8 : 2e-6);
  }
}

TEST_P(PlaneStage, FarFromTheOriginTheIncrementKeepsItsDigits)
{
  Random random(2);
  for (const Vector3d& centre : {Vector3d(1e4, -2e4, 100), Vector3d(4e5, 5e6, 100)}) {
    Surface target = ellipsoid(random, GetParam().affordable(3000), {60, 40, 25}, centre);
    const Cloud source = moved(target.points,
                               Eigen::Translation3d(centre) * motion({1, 2, 3}, 1e-3, {0.25, -0.5, 0.125}) *
                                   Eigen::Translation3d(-centre));
    const Estimate found = estimate(source, target.points, target.normals);
    EXPECT_EQ(found.degeneracy, Degeneracy::None);
    EXPECT_LT(
        rmsDifference(isometryOf(found.transform), planeReferenceOf(source, target.points, target.normals), source),
        isDouble() ? 1e-6 : 1e-4);
  }
}

TEST_P(PlaneStage, PairsThatAreNotFiniteTakeNoPart)
{
  Random random(3);
  const std::size_t n = 100;
  Surface target = ellipsoid(random, n, {3, 2, 1}, {0, 0, 0});
  Cloud source = moved(target.points, motion({0, 1, 0}, 0.01, {0.02, 0.01, 0}));
  const Estimate clean = estimate(source.rightCols(90), target.points.rightCols(90), target.normals.rightCols(90));
  source(1, 3) = not_a_number;
  target.points(0, 5) = infinity;
  target.normals(2, 7) = not_a_number;
  for (const int i : {0, 1, 2, 4, 6, 8, 9})
    target.normals.col(i).setConstant(not_a_number);
  const Estimate found = estimate(source, target.points, target.normals);
  EXPECT_EQ(found.pairs, 90U);
  EXPECT_EQ(found.transform.rotation, clean.transform.rotation);
  EXPECT_EQ(found.transform.translation, clean.transform.translation);
}

TEST_P(PlaneStage, TheSignOfANormalDoesNotMatter)
{
  Random random(4);
  Surface target = ellipsoid(random, 200, {3, 2, 1}, {0, 0, 0});
  const Cloud source = moved(target.points, motion({0, 1, 0}, 0.01, {0.02, 0.01, 0}));
  const Estimate found = estimate(source, target.points, target.normals);
  for (int i = 0; i < target.normals.cols(); i += 2)
    target.normals.col(i) *= -1;
  EXPECT_EQ(estimate(source, target.points, target.normals).transform.translation, found.transform.translation);
}

TEST_P(PlaneStage, GivesTheSameBitsAgain)
{
  Random random(5);
  const Surface target = ellipsoid(random, GetParam().affordable(5000), {3, 2, 1}, {0, 0, 0});
  const Cloud source = moved(target.points, motion({0, 1, 0}, 0.01, {0.02, 0.01, 0}));
  const Estimate first = estimate(source, target.points, target.normals);
  for (int again = 0; again < 3; ++again) {
    const Estimate found = estimate(source, target.points, target.normals);
    EXPECT_EQ(found.transform.rotation, first.transform.rotation);
    EXPECT_EQ(found.transform.translation, first.transform.translation);
  }
}

TEST_P(PlaneStage, WithinAPlaneNothingIsMoved)
{
  // Turned any way, at any distance: two tilts and the height are found, the three motions within stay as they were.
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const Isometry3d place = random.motion(seed % 2 ? 1000 : 1);
    const std::size_t n = GetParam().affordable(500);
    const Cloud target = moved(random.cloud(n, {4, 3, 0}, {0, 0, 0}), place);
    const Vector3d up = place.linear().col(2);
    const Cloud normals = up.cast<float>().replicate(1, n);
    const Cloud source = moved(target, Eigen::Translation3d(0.125 * up) * Isometry3d::Identity());
    const Estimate found = estimate(source, target, normals);
    EXPECT_EQ(found.degeneracy, Degeneracy::Sliding);
    EXPECT_EQ(found.free_motions, 3);
    const Isometry3d expected(Eigen::Translation3d(-0.125 * up));
    EXPECT_LT(rmsDifference(isometryOf(found.transform), expected, source), seed % 2 ? 4e-4 : 4e-6);
  }
}

TEST_P(PlaneStage, FreeMotionsAreCounted)
{
  Random random(6);
  const std::size_t n = GetParam().affordable(300);
  Cloud sphere(3, n), sphere_normals(3, n), cylinder(3, n), cylinder_normals(3, n);
  for (int i = 0; i < sphere.cols(); ++i) {
    const Vector3d u = random.direction();
    sphere.col(i) = (2 * u).cast<float>();
    sphere_normals.col(i) = u.cast<float>();
    const double angle = random.uniform(0, 7);
    cylinder.col(i) = Vector3d(std::cos(angle), std::sin(angle), random.uniform(-2, 2)).cast<float>();
    cylinder_normals.col(i) = Vector3d(std::cos(angle), std::sin(angle), 0).cast<float>();
  }
  const auto freeMotions = [&](const Cloud& points, const Cloud& normals) {
    const Estimate found = estimate(points, points, normals);
    EXPECT_LT(rmsDifference(isometryOf(found.transform), Isometry3d::Identity(), points), 1e-5);
    EXPECT_EQ(found.degeneracy, Degeneracy::Sliding);
    return found.free_motions;
  };
  EXPECT_EQ(freeMotions(sphere, sphere_normals), 3);
  EXPECT_EQ(freeMotions(cylinder, cylinder_normals), 2);
  const Cloud spot = Vector3d(1, 2, 3).cast<float>().replicate(1, n);
  EXPECT_EQ(freeMotions(spot, random.directions(n)), 3) << "at one place only the translation is determined";
  EXPECT_EQ(freeMotions(random.cloud(n), Cloud::Zero(3, n)), 6);
  EXPECT_EQ(freeMotions(random.cloud(1), random.directions(1)), 5);
  EXPECT_EQ(freeMotions(random.cloud(2), random.directions(2)), 4);
}

TEST_P(PlaneStage, AnyPairsGiveARigidMotion)
{
  for (unsigned seed = 0; seed < GetParam().affordable(6000) / 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const std::size_t n = random.count(1, 60);
    const Vector3d extents(random.count(0, 2), random.count(0, 2), random.count(0, 2));
    const Vector3d centre = seed % 4 == 3 ? Vector3d(4e3, -5e4, 100) : Vector3d(1, 0, -2);
    const Cloud target = random.cloud(n, extents, centre);
    Cloud normals = random.directions(n);
    // Of all directions, of one, of those in a plane, of none.
    const auto kind = random.count(0, 3);
    for (int i = 0; i < normals.cols(); ++i)
      if (kind == 1)
        normals.col(i) = normals.col(0);
      else if (kind == 2)
        normals(2, i) = 0;
      else if (kind == 3 && i % 2)
        normals.col(i).setZero();
    const double error = random.uniform(0, 1e-3);
    Cloud source(3, n);
    for (int i = 0; i < source.cols(); ++i)
      source.col(i) = (target.col(i).cast<double>() + random.direction() * error).cast<float>();
    const Estimate found = estimate(source, target, normals);
    const Isometry3d motion = isometryOf(found.transform);
    ASSERT_TRUE(motion.matrix().allFinite());
    ASSERT_LT((motion.linear() * motion.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    ASSERT_GE(found.free_motions, 0);
    ASSERT_EQ(found.degeneracy, found.free_motions > 0 ? Degeneracy::Sliding : Degeneracy::None);
    // Five pairs at most hold as many motions.
    ASSERT_GE(found.free_motions, 6 - int(n));
    // Few pairs may call for a turn beyond what is linear; otherwise the distances shrink.
    if (Eigen::AngleAxisd(motion.linear()).angle() > 0.02)
      continue;
    const auto residual = [&](const Isometry3d& pose) {
      const Eigen::Matrix3Xd gap = target.cast<double>() - pose * Eigen::Matrix3Xd(source.cast<double>());
      return std::sqrt(gap.cwiseProduct(normals.cast<double>()).colwise().sum().squaredNorm() / double(n));
    };
    const double rounding = 4 * centre.cwiseAbs().maxCoeff() * std::numeric_limits<float>::epsilon();
    ASSERT_LE(residual(motion), residual(Isometry3d::Identity()) * 1.05 + rounding + 1e-6);
  }
}

TEST_P(PlaneStage, NoPairsAreEmpty)
{
  const Cloud none(3, 0);
  const Estimate found = estimate(none, none, none);
  EXPECT_EQ(found.degeneracy, Degeneracy::Empty);
  EXPECT_EQ(found.transform.rotation, RigidTransform().rotation);
  const Cloud two = Cloud::Zero(3, 2);
  EXPECT_THROW(estimate(two, none, none), InvalidArgument);
  EXPECT_THROW(estimate(two, two, none), InvalidArgument);
}

class PlaneMatching : public OnDevice {};

TEST_P(PlaneMatching, MakesTheIncrementOfTheList)
{
  for (const bool device_searches : {false, true}) {
    if (device_searches && !GetParam().searches())
      continue;
    SCOPED_TRACE(device_searches ? "device" : "host");
    Random random(7);
    const std::size_t n = GetParam().affordable(2000);
    const Surface target = ellipsoid(random, n, {3, 2, 1}, {0, 0, 0});
    Cloud source = ellipsoid(random, n, {3, 2, 1}, {0, 0, 0}).points;
    source(0, 1) = not_a_number;
    Matcher matcher = makeMatcher(GetParam().device, GetParam().traits, GetParam().precision);
    const auto index = std::make_shared<search::NearestIndex>();
    if (device_searches)
      matcher.setTarget(matcher.makeTarget(viewOf(target.points)));
    else {
      index->build(viewOf(target.points));
      matcher.setTarget(matcher.makeTarget(index));
    }
    matcher.setTargetNormals(viewOf(target.normals));
    matcher.setSource(viewOf(source));
    const Isometry3d pose = motion({1, 1, 0}, 0.03, {0.1, 0, 0.05});
    const Matches matches = matcher.match(transformOf(pose), 30.0F / n);
    const auto listed = matcher.correspondences(transformOf(pose));
    ASSERT_EQ(matches.increment.pairs, listed.size());
    ASSERT_LT(listed.size(), 0.95 * n);
    ASSERT_GT(listed.size(), 0.2 * n);
    const Cloud at_pose = moved(source, pose);
    Cloud p(3, listed.size()), q(3, listed.size()), normals(3, listed.size());
    for (std::size_t i = 0; i < listed.size(); ++i) {
      p.col(i) = at_pose.col(listed[i].source);
      q.col(i) = target.points.col(listed[i].target);
      normals.col(i) = target.normals.col(listed[i].target);
    }
    const Isometry3d expected = planeReferenceOf(p, q, normals);
    // The small rotation turns about another point, which moves the answer by the square of its angle.
    EXPECT_LT(rmsDifference(isometryOf(matches.increment.transform), expected, p), 2e-4);
    EXPECT_GT(rmsDifference(isometryOf(matches.increment.transform), Isometry3d::Identity(), p), 0.05);
    const double residual =
        normals.cwiseProduct(q - p).colwise().sum().cast<double>().squaredNorm() / double(listed.size());
    EXPECT_NEAR(matches.mean_squared_residual, residual, 1e-5 * residual);
    EXPECT_GT(matches.mean_squared_distance, residual);

    matcher.setSource(viewOf(target.points));
    EXPECT_LT(matcher.match({}, infinity).mean_squared_residual, 1e-12);
    EXPECT_GT(matcher.match(transformOf(pose), infinity).mean_squared_residual, 1e-5);
  }
}

RUN_WITH_EVERY_KERNEL(PlaneStage);
RUN_WITH_EVERY_KERNEL(PlaneMatching);

} // namespace pcl_gpu_icp::test
