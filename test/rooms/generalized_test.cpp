// Increments of Generalized ICP: those of a double reference, for all matches and for some of them, on every device,
// kernel shape and precision.
#include "covariance_rows.h"
#include "increment_cases.h"

#include <pcl_gpu_icp/error.h>

#include <Eigen/Cholesky>

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Of pairs (source[i], target[i]): the motion with the least sum of squared Mahalanobis distances. The pairs' weights
/// are those at the identity.
Isometry3d generalizedReferenceOf(const Cloud& source, const Cloud& target, const Matrices& C_p, const Matrices& C_q)
{
  Isometry3d motion = Isometry3d::Identity();
  for (int step = 0; step < 30; ++step) {
    Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    for (int i = 0; i < source.cols(); ++i) {
      const Vector3d p = motion * source.col(i).cast<double>(), e = target.col(i).cast<double>() - p;
      const Matrix3d M = (C_q[i] + C_p[i]).inverse();
      Eigen::Matrix<double, 3, 6> J;
      J << 0, p[2], -p[1], 1, 0, 0, -p[2], 0, p[0], 0, 1, 0, p[1], -p[0], 0, 0, 0, 1;
      H += J.transpose() * M * J;
      b += J.transpose() * M * e;
    }
    const Eigen::Matrix<double, 6, 1> x = H.ldlt().solve(b);
    Isometry3d increment = Isometry3d::Identity();
    if (x.head<3>().norm() > 0)
      increment.linear() = Eigen::AngleAxisd(x.head<3>().norm(), x.head<3>().normalized()).toRotationMatrix();
    increment.translation() = x.tail<3>();
    motion = increment * motion;
  }
  return motion;
}

Matrices covariances(Random& random, std::size_t n)
{
  Matrices matrices;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3d normal = random.direction();
    matrices.emplace_back(Matrix3d::Identity() - 0.99 * normal * normal.transpose());
  }
  return matrices;
}

} // namespace

class GeneralizedIncrement : public IncrementCases {
protected:
  struct Pairs {
    Cloud source, target;
    Matrices of_source, of_target;
  };

  /// Turned by `angle`, with noise.
  static Pairs pairs(std::size_t n, double angle)
  {
    Random random(static_cast<unsigned>(n));
    Pairs made{{}, lattice(n), covariances(random, n), covariances(random, n)};
    made.source = turned(made.target, random, angle);
    return made;
  }

  static Matcher matcherOf(const Pairs& pairs)
  {
    Matcher matcher = makeMatcher(GetParam().device, GetParam().traits, GetParam().precision);
    const auto index = std::make_shared<search::NearestIndex>();
    index->build(viewOf(pairs.target));
    matcher.setTarget(matcher.makeTarget(index));
    matcher.setTargetCovariances(viewOfRows(inRows(pairs.of_target)));
    matcher.setSource(viewOf(pairs.source));
    matcher.setSourceCovariances(viewOfRows(inRows(pairs.of_source)));
    return matcher;
  }

  static Isometry3d referenceOf(const Pairs& pairs)
  {
    return generalizedReferenceOf(pairs.source, pairs.target, pairs.of_source, pairs.of_target);
  }
};

TEST_P(GeneralizedIncrement, IsTheMinimumForTheMatchesForEverySize)
{
  expectReferenceForEverySize(pairs, matcherOf, referenceOf);
}

TEST_P(GeneralizedIncrement, WeighsBySourceCovariancesAsThePoseTurnsThem)
{
  const std::size_t n = GetParam().affordable(1000);
  const Pairs p = pairs(n, 0.02);
  const Isometry3d turn = motion({1, 2, 3}, 2.0, {0.25, -0.5, 1});
  Pairs turned = p;
  turned.source = moved(p.source, turn.inverse());
  for (Matrix3d& covariance : turned.of_source)
    covariance = turn.linear().transpose() * covariance * turn.linear();
  Matcher matcher = matcherOf(turned);
  const Matches found = matcher.match(transformOf(turn), infinity);
  EXPECT_EQ(found.increment.pairs, n);
  const Isometry3d expected = referenceOf(p);
  EXPECT_LT(rmsDifference(isometryOf(found.increment.transform), expected, p.source), tolerance());
}

TEST_P(GeneralizedIncrement, OfSomeMatchesIsTheMinimumForThem)
{
  const Pairs p = pairs(GetParam().affordable(600), 0.02);
  Matcher matcher = matcherOf(p);
  matcher.match({}, infinity);
  const auto [kept, columns] = everyThird(matcher);
  Pairs part;
  part.source.resize(3, columns.size());
  part.target.resize(3, columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    part.source.col(i) = p.source.col(columns[i]);
    part.target.col(i) = p.target.col(columns[i]);
    part.of_source.push_back(p.of_source[columns[i]]);
    part.of_target.push_back(p.of_target[columns[i]]);
  }
  const Estimate found = matcher.estimate(kept, {}).increment;
  EXPECT_EQ(found.pairs, kept.size());
  const Isometry3d expected = referenceOf(part);
  EXPECT_LT(rmsDifference(isometryOf(found.transform), expected, p.source), tolerance());
  EXPECT_EQ(matcher.estimate({}, {}).increment.degeneracy, Degeneracy::Empty);
  EXPECT_THROW(matcher.estimate({{static_cast<std::int32_t>(p.source.cols()), 0, 0}}, {}), InvalidArgument);
  EXPECT_THROW(matcher.estimate({{-1, 0, 0}}, {}), InvalidArgument);
}

TEST_P(GeneralizedIncrement, CovariancesOfAnotherSourceAreNotUsed)
{
  const Pairs p = pairs(100, 0.01);
  Matcher matcher = makeMatcher(GetParam().device, GetParam().traits, GetParam().precision);
  EXPECT_THROW(matcher.setSourceCovariances(viewOfRows(inRows(p.of_source))), InvalidArgument);
  EXPECT_THROW(matcher.estimate({}, {}), InvalidArgument);
  matcher = matcherOf(p);
  EXPECT_THROW(matcher.setSourceNormals(viewOf(p.source)), InvalidArgument);
  PointCovariances few = inRows(p.of_source);
  few.pop_back();
  EXPECT_THROW(matcher.setSourceCovariances(viewOfRows(few)), InvalidArgument);
  EXPECT_THROW(matcher.setTargetCovariances(viewOfRows(few)), InvalidArgument);
  matcher.match({}, infinity);
  matcher.setSource(viewOf(p.source));
  EXPECT_THROW(matcher.match({}, infinity), InvalidArgument);
  EXPECT_EQ(matcher.match({}, infinity, false).increment.pairs, 100U);
  matcher.setSourceCovariances(viewOfRows(inRows(p.of_source)));
  EXPECT_EQ(matcher.match({}, infinity).increment.pairs, 100U);
}

TEST_P(GeneralizedIncrement, FromCovariancesThatAreNoneIsRefused)
{
  Pairs p = pairs(100, 0.01);
  p.of_source.assign(100, Matrix3d::Zero());
  p.of_target.assign(100, Matrix3d::Zero());
  Matcher matcher = matcherOf(p);
  EXPECT_THROW(matcher.match({}, infinity), InvalidArgument);
}

RUN_WITH_EVERY_KERNEL(GeneralizedIncrement);

TEST(SurfaceCovariances, AreThinAlongTheNormal)
{
  constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
  const Vector3d n = Vector3d(1, -2, 3).normalized();
  const auto covariances = surfaceCovariances(
      {{static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])}, {not_a_number, 0, 0}}, 0.001);
  ASSERT_EQ(covariances.size(), 2U);
  const auto& c = covariances[0];
  Matrix3d C;
  C << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
  EXPECT_LT((C * n - 0.001 * n).norm(), 1e-6);
  const Vector3d across = n.unitOrthogonal();
  EXPECT_LT((C * across - across).norm(), 1e-6);
  EXPECT_EQ(covariances[1], (std::array<float, 6>{1, 0, 0, 1, 0, 1}));
}

} // namespace pcl_gpu_icp::test
