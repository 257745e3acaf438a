// What increments weigh pairs by and what motions they are: losses against their definition, and both together with
// every metric against an iteratively reweighted reference in double, on every device, kernel shape and precision.
#include "covariance_rows.h"
#include "device_cases.h"
#include "engine/matcher_internals.h"
#include "reference.h"

#include <pcl_gpu_icp/error.h>

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr Metric metrics[] = {Metric::Point, Metric::Plane, Metric::Generalized};
constexpr Motions all_motions[] = {Motions::Rigid, Motions::Planar, Motions::Yaw, Motions::Translation};

struct Definition {
  LossFunction function;
  double tuning;
  double (*rho)(double r, double c); ///< of the residual
};
const Definition definitions[] = {
    {LossFunction::Huber, 1.345, [](double r, double c) { return r <= c ? r * r : 2 * c * r - c * c; }},
    {LossFunction::Cauchy, 2.385, [](double r, double c) { return c * c * std::log(1 + r * r / (c * c)); }},
    {LossFunction::GemanMcClure, 3.787, [](double r, double c) { return c * c * r * r / (c * c + r * r); }},
    {LossFunction::Tukey,
     4.685,
     [](double r, double c) { return r <= c ? c * c / 3 * (1 - std::pow(1 - r * r / (c * c), 3)) : c * c / 3; }},
    {LossFunction::Welsch, 2.985, [](double r, double c) { return c * c * (1 - std::exp(-r * r / (c * c))); }},
};

/// The derivative of rho by the squared residual, from rho alone.
double weightOf(const Definition& loss, double r, double c)
{
  const double s = r * r, step = 1e-5 * (s + 1e-3 * c * c), below = std::max(s - step, 0.0);
  return (loss.rho(std::sqrt(s + step), c) - loss.rho(std::sqrt(below), c)) / (s + step - below);
}

/// Pairs (source[i], target[i]) and their information.
struct Pairs {
  Cloud source, target;
  std::vector<Matrix3d> information;
  Cloud normals;
  PointCovariances of_source, of_target;

  Vector3d apart(int i, const Isometry3d& pose = Isometry3d::Identity()) const
  {
    return target.col(i).cast<double>() - pose * source.col(i).cast<double>();
  }
  double residual(int i, const Isometry3d& pose = Isometry3d::Identity()) const
  {
    const Vector3d e = apart(i, pose);
    return std::sqrt(e.dot(information[i] * e));
  }
};

/// A lattice and the same a small motion away, with noise, every fifth point farther off.
Pairs pairsFor(Metric metric, std::size_t n)
{
  Random random(static_cast<unsigned>(n));
  Pairs pairs;
  pairs.target = lattice(n);
  // At the corners 0.05, so that nothing else is nearer.
  const double angle = 0.05 / std::cbrt(static_cast<double>(n));
  pairs.source = moved(pairs.target, motion(random.direction(), angle, random.direction() * 0.05));
  pairs.normals.resize(3, pairs.target.cols());
  Matrices of_source, of_target;
  for (int i = 0; i < pairs.source.cols(); ++i) {
    pairs.source.col(i) += (random.direction() * (i % 5 == 0 ? 0.15 : 0.02)).cast<float>();
    const Vector3d normal = random.direction();
    pairs.normals.col(i) = normal.cast<float>();
    const Matrix3d C = Matrix3d::Identity() - 0.9 * normal * normal.transpose();
    // Of the source the same in every direction: no rotation changes it.
    of_source.emplace_back(Matrix3d::Identity() * 0.25);
    of_target.push_back(C);
    const Vector3d n_float = pairs.normals.col(i).cast<double>();
    pairs.information.push_back(metric == Metric::Point   ? Matrix3d::Identity()
                                : metric == Metric::Plane ? Matrix3d(n_float * n_float.transpose())
                                                          : Matrix3d((C + 0.25 * Matrix3d::Identity()).inverse()));
  }
  pairs.of_source = inRows(of_source);
  pairs.of_target = inRows(of_target);
  return pairs;
}

/// The motion that makes the sum of rho least: Gauss-Newton, reweighted at each step.
/// \param loss null: none
Isometry3d minimumOf(const Pairs& pairs, const Definition* loss, double scale, Motions motions)
{
  const auto allowed = unknownsOf(motions);
  Isometry3d pose = Isometry3d::Identity();
  for (int step = 0; step < 200; ++step) {
    Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    for (int i = 0; i < pairs.source.cols(); ++i) {
      const Vector3d p = pose * pairs.source.col(i).cast<double>(), e = pairs.apart(i, pose);
      const Matrix3d M = pairs.information[i] * (loss ? weightOf(*loss, pairs.residual(i, pose), scale) : 1);
      Eigen::Matrix<double, 3, 6> J;
      J << 0, p[2], -p[1], 1, 0, 0, -p[2], 0, p[0], 0, 1, 0, p[1], -p[0], 0, 0, 0, 1;
      H += J.transpose() * M * J;
      b += J.transpose() * M * e;
    }
    for (int i = 0; i < 6; ++i)
      if (!allowed[i]) {
        H.row(i).setZero();
        H.col(i).setZero();
        H(i, i) = 1;
        b[i] = 0;
      }
    const Eigen::Matrix<double, 6, 1> x = H.fullPivLu().solve(b);
    Isometry3d increment = Isometry3d::Identity();
    if (x.head<3>().norm() > 0)
      increment.linear() = Eigen::AngleAxisd(x.head<3>().norm(), x.head<3>().normalized()).toRotationMatrix();
    increment.translation() = x.tail<3>();
    pose = increment * pose;
  }
  return pose;
}

} // namespace

class Objective : public OnDevice {
protected:
  static Matcher matcherOf(Metric metric, const Pairs& pairs)
  {
    Matcher matcher = makeMatcher(GetParam().device, GetParam().traits, GetParam().precision);
    const auto index = std::make_shared<search::NearestIndex>();
    index->build(viewOf(pairs.target));
    matcher.setTarget(matcher.makeTarget(index));
    if (metric == Metric::Plane)
      matcher.setTargetNormals(viewOf(pairs.normals));
    if (metric == Metric::Generalized)
      matcher.setTargetCovariances(viewOfRows(pairs.of_target));
    matcher.setSource(viewOf(pairs.source));
    if (metric == Metric::Generalized)
      matcher.setSourceCovariances(viewOfRows(pairs.of_source));
    return matcher;
  }

  /// Iterates until the pose stays.
  static RigidTransform converged(Matcher& matcher, const Pairs& pairs, RigidTransform pose = {})
  {
    for (int iteration = 0; iteration < 200; ++iteration) {
      const Matches found = matcher.match(pose, infinity);
      EXPECT_EQ(found.increment.pairs, static_cast<std::size_t>(pairs.source.cols()));
      pose = compose(found.increment.transform, pose);
      if (rmsDifference(isometryOf(found.increment.transform), Isometry3d::Identity(), pairs.source) < 1e-7)
        break;
    }
    for (const Correspondence& c : matcher.correspondences(pose))
      EXPECT_EQ(c.source, c.target);
    return pose;
  }

  static double tolerance() { return GetParam().precision == Precision::Double ? 2e-6 : 2e-5; }
};

TEST_P(Objective, WeightsAreTheDerivativeOfTheLossForEverySize)
{
  constexpr double scale = 0.1;
  for (const std::size_t n : GetParam().sizes(3000)) {
    if (n < 12)
      continue;
    const Pairs pairs = pairsFor(Metric::Point, n);
    Matcher matcher = matcherOf(Metric::Point, pairs);
    matcher.setMotions(Motions::Translation);
    for (const Definition& loss : definitions) {
      SCOPED_TRACE(toString(loss.function) + (", " + std::to_string(n)));
      matcher.setLoss({loss.function, scale});
      const Matches found = matcher.match({}, infinity);
      Vector3d sum = Vector3d::Zero();
      double weights = 0, cost = 0;
      for (int i = 0; i < pairs.source.cols(); ++i) {
        const double weight = weightOf(loss, pairs.residual(i), scale);
        sum += weight * pairs.apart(i);
        weights += weight;
        cost += loss.rho(pairs.residual(i), scale);
      }
      const auto& t = found.increment.transform.translation;
      EXPECT_LT((vectorOf(t) - sum / weights).norm(), 2e-6);
      EXPECT_NEAR(found.mean_squared_residual * static_cast<double>(n), cost, 1e-5 * cost);
      EXPECT_NEAR(found.loss_scale, scale, 1e-7);
    }
  }
}

TEST_P(Objective, WithLossIsTheReweightedMinimum)
{
  constexpr std::size_t n = 100;
  for (const Metric metric : metrics) {
    const Pairs pairs = pairsFor(metric, n);
    Matcher matcher = matcherOf(metric, pairs);
    for (const Definition& loss : definitions) {
      SCOPED_TRACE(toString(metric) + std::string(", ") + toString(loss.function));
      constexpr double scale = 0.15;
      matcher.setLoss({loss.function, scale});
      const Isometry3d found = isometryOf(converged(matcher, pairs));
      EXPECT_LT(rmsDifference(found, minimumOf(pairs, &loss, scale, Motions::Rigid), pairs.source), tolerance());
    }
  }
}

TEST_P(Objective, OneStepAtATimeLeadsToTheSameMinimum)
{
  constexpr std::size_t n = 100;
  constexpr double scale = 0.15;
  const Definition& loss = definitions[2];
  for (const Metric metric : {Metric::Point, Metric::Generalized}) {
    SCOPED_TRACE(toString(metric));
    const Pairs pairs = pairsFor(metric, n);
    Matcher matcher = matcherOf(metric, pairs);
    matcher.setLoss({loss.function, scale});
    const RigidTransform all_steps = matcher.match({}, infinity).increment.transform;
    matcher.setSteps(1);
    EXPECT_NE(matcher.match({}, infinity).increment.transform.translation, all_steps.translation);
    const Isometry3d found = isometryOf(converged(matcher, pairs));
    EXPECT_LT(rmsDifference(found, minimumOf(pairs, &loss, scale, Motions::Rigid), pairs.source), tolerance());
  }
}

TEST_P(Objective, WithFewerMotionsIsTheMinimumAmongThem)
{
  constexpr std::size_t n = 100;
  for (const Metric metric : metrics)
    for (const Definition* loss : {static_cast<const Definition*>(nullptr), &definitions[1]}) {
      const Pairs pairs = pairsFor(metric, n);
      Matcher matcher = matcherOf(metric, pairs);
      if (loss)
        matcher.setLoss({loss->function, 0.15});
      for (const Motions motions : all_motions) {
        SCOPED_TRACE(toString(metric) + std::string(loss ? ", loss, " : ", ") + toString(motions));
        matcher.setMotions(motions);
        const RigidTransform pose = converged(matcher, pairs);
        EXPECT_LT(rmsDifference(isometryOf(pose), minimumOf(pairs, loss, 0.15, motions), pairs.source), tolerance());
      }
    }
}

TEST_P(Objective, WithFewerMotionsKeepsTheRestOfTheGuess)
{
  const Pairs at_home = pairsFor(Metric::Plane, GetParam().affordable(300));
  const RigidTransform guess = transformOf(motion({1, -2, 0.5}, 1.2, {3, 1, -2}));
  Pairs pairs = at_home;
  pairs.source = moved(at_home.source, isometryOf(guess).inverse());
  for (const Metric metric : metrics) {
    Matcher matcher = matcherOf(metric, pairs);
    for (const Motions motions : {Motions::Planar, Motions::Yaw, Motions::Translation}) {
      SCOPED_TRACE(toString(metric) + std::string(", ") + toString(motions));
      matcher.setMotions(motions);
      RigidTransform pose = guess;
      for (int iteration = 0; iteration < 5; ++iteration)
        pose = compose(matcher.match(pose, infinity).increment.transform, pose);
      const RigidTransform done = compose(pose, inverse(guess));
      const auto unknowns = unknownsOf(motions);
      for (const int entry : {2, 5, 6, 7})
        EXPECT_NEAR(done.rotation[entry], 0, 1e-15);
      EXPECT_NEAR(done.rotation[8], 1, 1e-15);
      EXPECT_EQ(std::abs(done.rotation[1]) > 1e-6, unknowns[2]);
      if (unknowns[5])
        EXPECT_GT(std::abs(done.translation[2]), 1e-4);
      else
        EXPECT_NEAR(done.translation[2], 0, 1e-14);
    }
  }
}

TEST_P(Objective, WithAnEndlessScaleHasTheBitsOfNone)
{
  for (const Metric metric : metrics) {
    const Pairs pairs = pairsFor(metric, GetParam().affordable(400));
    Matcher matcher = matcherOf(metric, pairs);
    matcher.setMotions(Motions::Yaw); // by the same sums for every metric
    const RigidTransform plain = matcher.match({}, infinity).increment.transform;
    for (const Definition& loss : definitions)
      for (const double scale : {1e15, std::numeric_limits<double>::infinity()}) {
        SCOPED_TRACE(toString(metric) + std::string(", ") + toString(loss.function));
        matcher.setLoss({loss.function, scale});
        const RigidTransform weighed = matcher.match({}, infinity).increment.transform;
        EXPECT_EQ(weighed.rotation, plain.rotation);
        EXPECT_EQ(weighed.translation, plain.translation);
      }
  }
}

TEST_P(Objective, WithoutAScaleTakesItFromTheMedian)
{
  const std::size_t n = GetParam().affordable(401);
  for (const Metric metric : metrics) {
    const Pairs pairs = pairsFor(metric, n);
    Matcher matcher = matcherOf(metric, pairs);
    std::vector<double> residuals;
    for (int i = 0; i < pairs.source.cols(); ++i)
      residuals.push_back(pairs.residual(i));
    std::sort(residuals.begin(), residuals.end());
    const double median = residuals[n / 2];
    for (const Definition& loss : definitions) {
      SCOPED_TRACE(toString(metric) + std::string(", ") + toString(loss.function));
      matcher.setLoss({loss.function});
      const Matches found = matcher.match({}, infinity);
      const double scale = 1.4826 * loss.tuning * median;
      EXPECT_NEAR(found.loss_scale, scale, 1e-4 * scale);
      matcher.setLoss({loss.function, found.loss_scale});
      const RigidTransform given = matcher.match({}, infinity).increment.transform;
      EXPECT_LT(rmsDifference(isometryOf(found.increment.transform), isometryOf(given), pairs.source), 1e-6);
    }
  }
}

TEST_P(Objective, ResidualsOfPointsWithoutAPairDoNotCountForTheScale)
{
  Pairs pairs = pairsFor(Metric::Plane, GetParam().affordable(300));
  std::vector<double> residuals;
  for (int i = 0; i < pairs.source.cols(); ++i) {
    if (i % 3 == 0)
      pairs.source.col(i) += Eigen::Vector3f(1000, 0, 0);
    else if (i % 3 == 1)
      pairs.normals.col(i).setConstant(std::numeric_limits<float>::quiet_NaN());
    else
      residuals.push_back(pairs.residual(i));
  }
  std::sort(residuals.begin(), residuals.end());
  Matcher matcher = matcherOf(Metric::Plane, pairs);
  matcher.setLoss({LossFunction::Huber});
  const double scale = 1.4826 * 1.345 * residuals[residuals.size() / 2];
  EXPECT_NEAR(matcher.match({}, 1).loss_scale, scale, 1e-4 * scale);
}

TEST_P(Objective, WhereMostResidualsAreNothingHasAScaleAllTheSame)
{
  Pairs pairs = pairsFor(Metric::Point, GetParam().affordable(100));
  pairs.source = pairs.target;
  Matcher matcher = matcherOf(Metric::Point, pairs);
  for (const Definition& loss : definitions) {
    SCOPED_TRACE(toString(loss.function));
    matcher.setLoss({loss.function});
    const Matches found = matcher.match({}, infinity);
    EXPECT_EQ(found.loss_scale, 1);
    EXPECT_EQ(found.increment.transform.translation, (std::array<double, 3>{0, 0, 0}));
  }
  pairs.source.col(0) += Eigen::Vector3f(0.25F, 0, 0);
  matcher.setSource(viewOf(pairs.source));
  for (const Definition& loss : definitions) {
    SCOPED_TRACE(toString(loss.function));
    matcher.setLoss({loss.function});
    const Matches found = matcher.match({}, infinity);
    const double scale = 1e-3 * 0.25 / std::sqrt(static_cast<double>(pairs.source.cols())) * loss.tuning;
    EXPECT_NEAR(found.loss_scale, scale, 1e-5 * scale);
    EXPECT_LT(vectorOf(found.increment.transform.translation).norm(), 1e-3 * 0.25);
  }
}

TEST_P(Objective, HasNoUncertaintyWithoutAnIncrement)
{
  const Pairs pairs = pairsFor(Metric::Plane, GetParam().affordable(100));
  for (const Metric metric : metrics) {
    SCOPED_TRACE(toString(metric));
    Matcher matcher = matcherOf(metric, pairs);
    EXPECT_FALSE(matcher.uncertainty({}));
    matcher.match({}, infinity);
    EXPECT_TRUE(matcher.uncertainty({}));
    matcher.match({}, infinity, false);
    EXPECT_FALSE(matcher.uncertainty({}));
    matcher.match({}, infinity);
    matcher.setSource(viewOf(pairs.target));
    EXPECT_FALSE(matcher.uncertainty({}));
  }
  EXPECT_FALSE(makeMatcher(GetParam().device, GetParam().traits, GetParam().precision).uncertainty({}));
}

TEST_P(Objective, RefusesAScaleThatIsNone)
{
  Matcher matcher = makeMatcher(GetParam().device, GetParam().traits, GetParam().precision);
  for (const double scale : {-1.0, std::numeric_limits<double>::quiet_NaN(), 1e-30, 1e30})
    EXPECT_THROW(matcher.setLoss({LossFunction::Huber, scale}), InvalidArgument) << scale;
}

RUN_WITH_EVERY_KERNEL(Objective);

} // namespace pcl_gpu_icp::test
