// Increments of the symmetric objective: those of a double reference, for all matches and for some of them, on every
// device, kernel shape and precision.
#include "increment_cases.h"

#include <pcl_gpu_icp/error.h>

#include <Eigen/QR>

#include <limits>

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

struct Pairs {
  Cloud source, target, of_source, of_target; ///< of which these are the normals
};

/// Of pairs (source[i], target[i]): the least squares through the 6 n equations themselves, turned by half before the
/// shift and by half after it.
Isometry3d symmetricReferenceOf(const Pairs& pairs)
{
  const Eigen::Matrix3Xd p = pairs.source.cast<double>(), q = pairs.target.cast<double>();
  const Vector3d centre = p.rowwise().mean();
  Eigen::MatrixXd J(p.cols(), 6);
  Eigen::VectorXd r(p.cols());
  for (int i = 0; i < p.cols(); ++i) {
    const Vector3d n_p = pairs.of_source.col(i).cast<double>(), n_q = pairs.of_target.col(i).cast<double>();
    const Vector3d n = n_p.dot(n_q) < 0 ? Vector3d(n_q - n_p) : Vector3d(n_q + n_p);
    J.row(i) << Vector3d(p.col(i) + q.col(i) - 2 * centre).cross(n).transpose(), n.transpose();
    r[i] = n.dot(q.col(i) - p.col(i));
  }
  const Eigen::Matrix<double, 6, 1> x = J.colPivHouseholderQr().solve(r);
  const Isometry3d half(Eigen::AngleAxisd(x[2], Vector3d::UnitZ()) * Eigen::AngleAxisd(x[1], Vector3d::UnitY()) *
                        Eigen::AngleAxisd(x[0], Vector3d::UnitX()));
  return Eigen::Translation3d(centre) * half * Eigen::Translation3d(x.tail<3>()) * half * Eigen::Translation3d(-centre);
}

/// A lattice and the same turned by `angle`, with noise; normals of any direction.
Pairs pairsOf(std::size_t n, double angle)
{
  Random random(static_cast<unsigned>(n));
  Pairs made{{}, lattice(n), random.directions(n), random.directions(n)};
  made.source = turned(made.target, random, angle);
  return made;
}

} // namespace

class SymmetricIncrement : public IncrementCases {
protected:
  static Matcher matcherOf(const Pairs& pairs)
  {
    Matcher matcher = makeMatcher(GetParam().device, GetParam().traits, GetParam().precision);
    const auto index = std::make_shared<search::NearestIndex>();
    index->build(viewOf(pairs.target));
    matcher.setTarget(matcher.makeTarget(index));
    matcher.setTargetNormals(viewOf(pairs.of_target));
    matcher.setSource(viewOf(pairs.source));
    matcher.setSourceNormals(viewOf(pairs.of_source));
    return matcher;
  }
};

TEST_P(SymmetricIncrement, IsThatOfTheReferenceForEverySize)
{
  expectReferenceForEverySize(pairsOf, matcherOf, symmetricReferenceOf);
}

TEST_P(SymmetricIncrement, TurnsTheSourcesNormalsWithThePose)
{
  const std::size_t n = GetParam().affordable(1000);
  const Pairs pairs = pairsOf(n, 0.02);
  const Isometry3d turn = motion({1, 2, 3}, 2.0, {0.25, -0.5, 1});
  Pairs turned = pairs;
  turned.source = moved(pairs.source, turn.inverse());
  turned.of_source = (turn.linear().transpose() * pairs.of_source.cast<double>()).cast<float>();
  Matcher matcher = matcherOf(turned);
  const Matches found = matcher.match(transformOf(turn), infinity);
  EXPECT_EQ(found.increment.pairs, n);
  EXPECT_LT(rmsDifference(isometryOf(found.increment.transform), symmetricReferenceOf(pairs), pairs.source),
            tolerance());
}

TEST_P(SymmetricIncrement, TheSignsOfNormalsDoNotMatter)
{
  Pairs pairs = pairsOf(200, 0.02);
  const RigidTransform found = matcherOf(pairs).match({}, infinity).increment.transform;
  for (int i = 0; i < pairs.source.cols(); ++i) {
    pairs.of_source.col(i) *= i % 2 ? -1 : 1;
    pairs.of_target.col(i) *= i % 3 ? -1 : 1;
  }
  EXPECT_EQ(matcherOf(pairs).match({}, infinity).increment.transform.translation, found.translation);
}

TEST_P(SymmetricIncrement, PairsWithoutBothNormalsTakeNoPart)
{
  Pairs pairs = pairsOf(60, 0.02);
  pairs.of_source(1, 3) = not_a_number;
  pairs.of_source.col(7).setZero();
  pairs.of_target(0, 12) = infinity;
  pairs.of_target.col(20).setZero();
  Pairs with_both;
  std::vector<int> columns;
  for (int i = 0; i < pairs.source.cols(); ++i)
    if (i != 3 && i != 7 && i != 12 && i != 20)
      columns.push_back(i);
  with_both.source = pairs.source(Eigen::all, columns);
  with_both.target = pairs.target(Eigen::all, columns);
  with_both.of_source = pairs.of_source(Eigen::all, columns);
  with_both.of_target = pairs.of_target(Eigen::all, columns);
  const Matches found = matcherOf(pairs).match({}, infinity);
  EXPECT_LT(rmsDifference(isometryOf(found.increment.transform), symmetricReferenceOf(with_both), pairs.source),
            10 * tolerance()); // the small turn is about the centre of all
}

TEST_P(SymmetricIncrement, OfSomeMatchesIsThatOfTheReferenceForThem)
{
  const Pairs pairs = pairsOf(GetParam().affordable(600), 0.002);
  Matcher matcher = matcherOf(pairs);
  matcher.match({}, infinity);
  const auto [kept, columns] = everyThird(matcher);
  const Pairs part{pairs.source(Eigen::all, columns),
                   pairs.target(Eigen::all, columns),
                   pairs.of_source(Eigen::all, columns),
                   pairs.of_target(Eigen::all, columns)};
  const Estimate found = matcher.estimate(kept, {}).increment;
  EXPECT_EQ(found.pairs, kept.size());
  EXPECT_LT(rmsDifference(isometryOf(found.transform), symmetricReferenceOf(part), pairs.source), 10 * tolerance());
}

TEST_P(SymmetricIncrement, NormalsOfAnotherSourceAreNotUsed)
{
  const Pairs pairs = pairsOf(100, 0.01);
  Matcher matcher = makeMatcher(GetParam().device, GetParam().traits, GetParam().precision);
  EXPECT_THROW(matcher.setSourceNormals(viewOf(pairs.of_source)), InvalidArgument);
  matcher = matcherOf(pairs);
  EXPECT_THROW(matcher.setSourceCovariances(viewOf(pairs.of_source)), InvalidArgument);
  EXPECT_THROW(matcher.setSourceNormals(viewOf(Cloud(pairs.of_source.leftCols(99)))), InvalidArgument);
  matcher.match({}, infinity);
  matcher.setSource(viewOf(pairs.source));
  EXPECT_THROW(matcher.match({}, infinity), InvalidArgument);
  matcher.setSourceNormals(viewOf(pairs.of_source));
  EXPECT_EQ(matcher.match({}, infinity).increment.pairs, 100U);
}

RUN_WITH_EVERY_KERNEL(SymmetricIncrement);

} // namespace pcl_gpu_icp::test
