// Features of points: as their definition says, whatever the cloud's pose and the signs of its normals; a cloud that
// moved finds its own points again.
#include "search/point_features.h"

#include "reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_gpu_icp::test {
namespace {

using Eigen::Vector3d;
using search::mutualMatches;
using search::PointFeature;
using search::pointFeatures;

constexpr std::size_t bins = PointFeature::bins;
constexpr double radius = 0.4;

struct Surface {
  std::vector<PlacedPoint> points;
  std::vector<std::array<float, 3>> normals;

  void add(const Vector3d& place, const Vector3d& normal)
  {
    const Eigen::Vector3f p = place.cast<float>(), n = normal.cast<float>();
    points.push_back({{p[0], p[1], p[2]}, static_cast<std::int32_t>(points.size())});
    normals.push_back({n[0], n[1], n[2]});
  }

  std::vector<PointFeature> features(unsigned threads = 1) const
  {
    return pointFeatures(points, normals, radius, threads);
  }
};

/// Hills of no symmetry, moved, with normals of any sign.
Surface hills(const Eigen::Isometry3d& motion, unsigned seed_of_signs)
{
  Random places(1), signs(seed_of_signs);
  Surface surface;
  for (int i = 0; i < 1500; ++i) {
    const double x = places.uniform(-2, 2), y = places.uniform(-1.5, 1.5);
    const double z = 0.3 * std::sin(3 * x + y * y) + 0.2 * std::cos(2 * y + x);
    const Vector3d normal(-0.9 * std::cos(3 * x + y * y) + 0.2 * std::sin(2 * y + x),
                          -0.6 * y * std::cos(3 * x + y * y) + 0.4 * std::sin(2 * y + x),
                          1);
    const double sign = signs.uniform(-1, 1) < 0 ? -1 : 1;
    surface.add(motion * Vector3d(x, y, z), sign * (motion.linear() * normal.normalized()));
  }
  return surface;
}

TEST(PointFeatures, AreAsTheirDefinitionSays)
{
  // Two points, of which the second's normal leans away by half a radian: the angles are 0, 0 and -sin(0.5), and twice
  // 0.5. Neighbours below the normal turn the signs of the latter.
  Surface two;
  two.add({0, 0, 0}, {0, 0, 1});
  two.add({0.2, 0, 0}, {std::sin(0.5), 0, std::cos(0.5)});
  PointFeature expected;
  const auto at = [](double share) { return static_cast<std::size_t>(share * bins); };
  expected.histogram[at(0.5)] = 2;
  expected.histogram[bins + at(0.5)] = 1;
  expected.histogram[bins + at((std::sin(0.5) + 1) / 2)] = 1;
  expected.histogram[2 * bins + at((-0.5 / M_PI_2 + 1) / 2)] = 2;
  for (const PointFeature& feature : two.features()) {
    EXPECT_TRUE(feature.is_known);
    EXPECT_EQ(feature.histogram, expected.histogram);
  }
}

TEST(PointFeatures, DoNotDependOnThePoseOrTheSignsOfNormals)
{
  Random random(5);
  const auto features = hills(Eigen::Isometry3d::Identity(), 1).features();
  const auto others = hills(random.motion(5), 2).features();
  std::size_t alike = 0;
  for (std::size_t i = 0; i < features.size(); ++i) {
    ASSERT_TRUE(features[i].is_known && others[i].is_known);
    double difference = 0;
    for (std::size_t bin = 0; bin < 3 * bins; ++bin)
      difference += std::abs(features[i].histogram[bin] - others[i].histogram[bin]);
    alike += difference < 0.1 ? 1 : 0; // of six; roundings move an angle to the next bin
  }
  EXPECT_GT(alike, features.size() * 99 / 100);
}

TEST(PointFeatures, FindThePointsAgain)
{
  Random random(6);
  const auto features = hills(Eigen::Isometry3d::Identity(), 3).features();
  const auto others = hills(random.motion(5), 4).features();
  const auto matches = mutualMatches(features, others, 10000, 1);
  ASSERT_GT(matches.size(), features.size() * 95 / 100);
  const auto right = std::count_if(
      matches.begin(), matches.end(), [](const search::FeatureMatch& match) { return match.source == match.target; });
  EXPECT_GT(static_cast<std::size_t>(right), matches.size() * 99 / 100);

  const auto best = mutualMatches(features, others, 100, 1);
  EXPECT_EQ(best.size(), 100U);
  EXPECT_TRUE(
      std::is_sorted(best.begin(), best.end(), [](const auto& a, const auto& b) { return a.source < b.source; }));
}

TEST(PointFeatures, AreNoneWithoutANormalOrANeighbour)
{
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  Surface surface = hills(Eigen::Isometry3d::Identity(), 1);
  surface.normals[7] = {nan, nan, nan};
  surface.add({50, 0, 0}, {0, 0, 1});
  const auto features = surface.features();
  EXPECT_FALSE(features[7].is_known);
  EXPECT_FALSE(features.back().is_known);
  for (const search::FeatureMatch& match : mutualMatches(features, features, 10000, 1)) {
    EXPECT_EQ(match.source, match.target);
    EXPECT_NE(match.source, 7U);
    EXPECT_NE(match.source, features.size() - 1);
  }
  EXPECT_TRUE(pointFeatures({}, {}, radius, 1).empty());
  EXPECT_TRUE(mutualMatches({}, features, 10, 1).empty());
}

TEST(PointFeatures, OfWhatIsSymmetricMatchNothing)
{
  // The faces of a cube, in a grid: a turn by 90 degrees is the same.
  Surface cube;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (int i = -4; i <= 4; ++i)
        for (int j = -4; j <= 4; ++j) {
          Vector3d place(side, i / 5.0, j / 5.0), normal(side, 0, 0);
          std::rotate(place.data(), place.data() + axis, place.data() + 3);
          std::rotate(normal.data(), normal.data() + axis, normal.data() + 3);
          cube.add(place, normal);
        }
  const auto features = cube.features();
  EXPECT_TRUE(std::all_of(features.begin(), features.end(), [](const PointFeature& each) { return each.is_known; }));
  EXPECT_TRUE(mutualMatches(features, features, 1000, 1).empty());
}

TEST(PointFeatures, AreTheSameForAnyNumberOfThreads)
{
  const Surface surface = hills(Eigen::Isometry3d::Identity(), 1);
  const auto one = surface.features(1), four = surface.features(4);
  for (std::size_t i = 0; i < one.size(); ++i)
    EXPECT_EQ(one[i].histogram, four[i].histogram);
  const auto of_one = mutualMatches(one, one, 500, 1), of_four = mutualMatches(one, one, 500, 4);
  ASSERT_EQ(of_one.size(), of_four.size());
  for (std::size_t i = 0; i < of_one.size(); ++i)
    EXPECT_EQ(of_one[i].target, of_four[i].target);
}

} // namespace
} // namespace pcl_gpu_icp::test
