// NormalEstimator: the direction of least variance of the k nearest points, compared with Eigen's eigenvectors over the
// points found by looking at all of them, on every device, kernel shape and precision.
#include "device_cases.h"
#include "engine/normal_estimator_internals.h"
#include "reference.h"

#include <pcl_gpu_icp/error.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace pcl_gpu_icp::test {

using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

Vector3f vectorOf(const std::array<float, 3>& normal) { return {normal[0], normal[1], normal[2]}; }

struct NormalReference {
  Vector3d normal;
  Vector3d eigenvalues; ///< ascending
};

NormalReference normalReferenceAt(const Cloud& cloud, int point, std::size_t k)
{
  std::vector<int> order(cloud.cols());
  std::iota(order.begin(), order.end(), 0);
  k = std::min(k, order.size());
  const auto distance = [&](int i) { return (cloud.col(i) - cloud.col(point)).squaredNorm(); };
  std::partial_sort(
      order.begin(), order.begin() + k, order.end(), [&](int a, int b) { return distance(a) < distance(b); });
  Eigen::Matrix3Xd nearest(3, k);
  for (std::size_t i = 0; i < k; ++i)
    nearest.col(i) = cloud.col(order[i]).cast<double>();
  nearest.colwise() -= Vector3d(nearest.rowwise().mean());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(nearest * nearest.transpose());
  return {solver.eigenvectors().col(0), solver.eigenvalues()};
}

Cloud sphere(Random& random, std::size_t n, double radius, const Vector3d& centre)
{
  Cloud cloud(3, n);
  for (int i = 0; i < cloud.cols(); ++i)
    cloud.col(i) = (random.direction() * radius + centre).cast<float>();
  return cloud;
}

} // namespace

class NormalEstimation : public OnDevice {
protected:
  std::vector<std::array<float, 3>> estimate(const Cloud& cloud, unsigned k = 20)
  {
    return estimator_.estimate(viewOf(cloud), k);
  }
  std::size_t affordable(std::size_t n) const { return GetParam().affordable(n); }

  NormalEstimator estimator_{makeNormalEstimator(GetParam().device, GetParam().traits, GetParam().precision)};
};

TEST_P(NormalEstimation, AreThoseOfTheReference)
{
  unsigned seed = 0;
  for (const std::size_t n : {3, 15, 16, 17, 255, 257, 600})
    for (const unsigned k : {3U, 7U, 20U, 32U}) {
      if (n > affordable(600))
        break;
      SCOPED_TRACE("seed " + std::to_string(++seed) + ", " + std::to_string(n) + " points, k " + std::to_string(k));
      Random random(seed);
      const Cloud cloud = seed % 2 ? random.cloud(n) : sphere(random, n, 3, {1, 2, 3});
      const auto normals = estimate(cloud, k);
      ASSERT_EQ(normals.size(), n);
      for (int i = 0; i < cloud.cols(); ++i) {
        const NormalReference expected = normalReferenceAt(cloud, i, k);
        const Vector3d normal = vectorOf(normals[i]).cast<double>();
        ASSERT_NEAR(normal.norm(), 1, 1e-5);
        // What rounding does to the direction grows as the two least eigenvalues come together.
        const double apart = (expected.eigenvalues[1] - expected.eigenvalues[0]) / expected.eigenvalues[2];
        ASSERT_LT(normal.cross(expected.normal).norm(), 1e-6 + 1e-6 / apart) << "point " << i;
      }
    }
}

TEST_P(NormalEstimation, OfAPlaneAreItsOwn)
{
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const Eigen::Isometry3d place = random.motion(seed % 2 ? 100 : 1);
    const Cloud plane = moved(random.cloud(affordable(400), {4, 3, 0}, {0, 0, 0}), place);
    for (const auto& normal : estimate(plane))
      ASSERT_LT(Vector3d(place.linear().col(2)).cross(vectorOf(normal).cast<double>()).norm(), seed % 2 ? 1e-3 : 1e-5);
  }
}

TEST_P(NormalEstimation, MorePointsThanAreAskedForAtOnce)
{
  Random random(1);
  const std::size_t n = affordable(40'000);
  const Cloud cloud = sphere(random, n, 5, {0, 0, 0});
  const auto normals = estimate(cloud);
  std::size_t right = 0;
  for (std::size_t i = 0; i < n; ++i)
    right += std::abs(vectorOf(normals[i]).dot(cloud.col(i).normalized())) > 0.9 ? 1 : 0;
  EXPECT_EQ(right, n);
  EXPECT_EQ(estimate(cloud), normals) << "the same bits again";
}

TEST_P(NormalEstimation, FarFromTheOrigin)
{
  Random random(2);
  const Vector3d centre(4e5, 5e6, 100);
  const Cloud cloud = sphere(random, affordable(500), 100, centre);
  for (const auto& normal : estimate(cloud))
    ASSERT_TRUE(vectorOf(normal).allFinite());
  const auto normals = estimate(cloud);
  for (int i = 0; i < cloud.cols(); ++i) {
    const NormalReference expected = normalReferenceAt(cloud, i, 20);
    const double apart = (expected.eigenvalues[1] - expected.eigenvalues[0]) / expected.eigenvalues[2];
    ASSERT_LT(vectorOf(normals[i]).cast<double>().cross(expected.normal).norm(), 1e-6 + 1e-6 / apart);
  }
}

TEST_P(NormalEstimation, WherePointsSpanNoPlaneThereIsNone)
{
  Random random(3);
  const auto isNone = [](const std::array<float, 3>& normal) { return std::isnan(normal[0] + normal[1] + normal[2]); };
  const auto none = [&](const Cloud& cloud) {
    const auto normals = estimate(cloud);
    return std::count_if(normals.begin(), normals.end(), isNone);
  };
  EXPECT_EQ(none(random.cloud(2)), 2);
  EXPECT_EQ(none(random.cloud(50, {5, 0, 0}, {0, 1, 2})), 50) << "a line";
  EXPECT_EQ(none(moved(random.cloud(50, {5, 0, 0}, {0, 1, 2}), random.motion(3))), 50) << "any line";
  EXPECT_EQ(none(random.cloud(50, {0, 0, 0}, {1, 2, 3})), 50) << "one place";
  EXPECT_EQ(none(Cloud(3, 0)), 0);
  Cloud strays = random.cloud(50);
  strays(1, 7) = not_a_number;
  strays(0, 49) = std::numeric_limits<float>::infinity();
  const auto normals = estimate(strays);
  for (int i = 0; i < strays.cols(); ++i)
    EXPECT_EQ(isNone(normals[i]), i == 7 || i == 49) << i;
}

TEST_P(NormalEstimation, CoincidentPointsCountOnce)
{
  Random random(4);
  const Cloud once = random.cloud(60);
  Cloud repeated(3, 260);
  repeated << once, once.col(11).replicate(1, 200);
  const auto expected = estimate(once), found = estimate(repeated);
  for (int i = 0; i < repeated.cols(); ++i)
    EXPECT_LT((vectorOf(found[i]) - vectorOf(expected[i < 60 ? i : 11])).norm(), 1e-5) << i;
}

TEST_P(NormalEstimation, AnIndexNamesThePoints)
{
  Random random(5);
  const Cloud cloud = random.cloud(90);
  const std::vector<std::int32_t> index{80, 3, 3, 70, 5, 60, 1, 2};
  Cloud named(3, index.size());
  for (std::size_t i = 0; i < index.size(); ++i)
    named.col(i) = cloud.col(index[i]);
  Points points = viewOf(cloud);
  points.index = index.data();
  points.index_stride = sizeof(std::int32_t);
  points.count = index.size();
  EXPECT_EQ(estimator_.estimate(points), estimate(named));
}

TEST_P(NormalEstimation, OtherNumbersOfNeighboursAreRefused)
{
  Random random(6);
  const Cloud cloud = random.cloud(10);
  EXPECT_THROW(estimate(cloud, 2), InvalidArgument);
  EXPECT_THROW(estimate(cloud, 33), InvalidArgument);
}

RUN_WITH_EVERY_SEARCH(NormalEstimation);

} // namespace pcl_gpu_icp::test
