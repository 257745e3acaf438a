// Poses from nowhere: found for any rotation, for parts of a cloud and among the motions allowed; what is symmetric is
// said to be ambiguous; the same bits every time.
#include "reference.h"

#include <pcl_gpu_icp/pose_search.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

/// A hilly patch with a wall and a block, which looks like itself in one pose only.
Cloud scene(Random& random, std::size_t n)
{
  Cloud cloud(3, n);
  for (int i = 0; i < cloud.cols(); ++i) {
    const double u = random.uniform(-1, 1), v = random.uniform(-1, 1);
    Vector3d point;
    if (i % 5 == 0)
      point = {3, 2 * u, 0.8 + 0.8 * v}; // the wall
    else if (i % 7 == 0)
      point = {-1.5 + 0.4 * u, 1 + 0.5 * v, 1.2}; // the top of the block
    else
      point = {3 * u, 2 * v, 0.3 * std::sin(2 * u) + 0.2 * u * v};
    cloud.col(i) = point.cast<float>();
  }
  return cloud;
}

double degreesOff(const RigidTransform& found, const Isometry3d& expected)
{
  return Eigen::AngleAxisd(isometryOf(found).linear().transpose() * expected.linear()).angle() * 180 / M_PI;
}

double metresOff(const RigidTransform& found, const Isometry3d& expected, const Cloud& source)
{
  return rmsDifference(isometryOf(found), expected, source);
}

/// A room of 8 by 6 metres with a table, a cupboard and two boxes, whose walls are alike, without its ceiling.
Cloud room(Random& random, std::size_t n)
{
  struct Box {
    Vector3d centre, half;
    std::size_t points;
  };
  const Box boxes[] = {{{0, 0, 1.5}, {4, 3, 1.5}, n},
                       {{0.3, 0.8, 0.4}, {0.7, 0.4, 0.4}, n / 20},
                       {{-0.5, -1.2, 1}, {0.05, 0.6, 1}, n / 30},
                       {{2.5, -2, 0.5}, {0.4, 0.5, 0.5}, n / 30},
                       {{-3, 1.5, 0.6}, {0.5, 0.3, 0.6}, n / 30}};
  std::vector<Vector3d> points;
  for (const Box& box : boxes) {
    const Vector3d& h = box.half;
    const double faces[] = {h.y() * h.z(), h.x() * h.z(), h.x() * h.y()};
    for (std::size_t i = 0; i < box.points; ++i) {
      double place = random.uniform(0, faces[0] + faces[1] + faces[2]);
      int across = 0;
      while (across < 2 && place > faces[across])
        place -= faces[across++];
      Vector3d point(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      point[across] = std::copysign(1, point[across]);
      constexpr double ceiling = 2.9, noise = 0.004;
      const Vector3d at = box.centre + point.cwiseProduct(h);
      if (at.z() < ceiling)
        points.push_back(at + noise * Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)));
    }
  }
  Cloud cloud(3, points.size());
  for (int i = 0; i < cloud.cols(); ++i)
    cloud.col(i) = points[static_cast<std::size_t>(i)].cast<float>();
  return cloud;
}

/// What of the cloud has side * x below the limit.
Cloud cut(const Cloud& cloud, double side, double limit)
{
  std::vector<int> kept;
  for (int i = 0; i < cloud.cols(); ++i)
    if (side * cloud(0, i) < limit)
      kept.push_back(i);
  Cloud part(3, kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i)
    part.col(static_cast<int>(i)) = cloud.col(kept[i]);
  return part;
}

void expectFound(
    const PoseSearchResult& found, const Isometry3d& truth, const Cloud& source, double degrees, double metres)
{
  ASSERT_FALSE(found.poses.empty());
  EXPECT_LT(degreesOff(found.poses[0].transform, truth), degrees);
  EXPECT_LT(metresOff(found.poses[0].transform, truth, source), metres);
}

class PoseSearching : public testing::Test {
protected:
  Random random{11};
  PoseSearch poses{Device::select()};
};

TEST_F(PoseSearching, FindsAnyRotation)
{
  const Cloud target = scene(random, 6000);
  for (int trial = 0; trial < 4; ++trial) {
    SCOPED_TRACE(trial);
    const Isometry3d truth = random.motion(20);
    const Cloud source = moved(scene(random, 5000), truth.inverse());
    const PoseSearchResult found = poses.search(viewOf(source), viewOf(target));
    ASSERT_NO_FATAL_FAILURE(expectFound(found, truth, source, 3, 0.2));
    EXPECT_GT(found.poses[0].score, 0.5);
    EXPECT_FALSE(found.isAmbiguous());
    EXPECT_LT(found.starts, 20U) << "features lead to it";
  }
}

TEST_F(PoseSearching, FindsAPartOfTheTarget)
{
  const Cloud target = scene(random, 8000), all = scene(random, 8000);
  for (int trial = 0; trial < 2; ++trial) {
    SCOPED_TRACE(trial);
    // Two thirds of it, cut across.
    const Vector3d across = Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), 0).normalized();
    std::vector<int> kept;
    for (int i = 0; i < all.cols(); ++i)
      if (across.dot(all.col(i).cast<double>()) > -0.7)
        kept.push_back(i);
    Cloud part(3, kept.size());
    for (std::size_t i = 0; i < kept.size(); ++i)
      part.col(static_cast<int>(i)) = all.col(kept[i]);
    const Isometry3d truth = random.motion(5);
    const Cloud source = moved(part, truth.inverse());
    const PoseSearchResult found = poses.search(viewOf(source), viewOf(target));
    ASSERT_NO_FATAL_FAILURE(expectFound(found, truth, source, 4, 0.3));
  }
}

TEST_F(PoseSearching, FindsHalvesByWhatTheyHaveInCommon)
{
  // Hills of which the clouds share the middle third, half of each.
  const Cloud tops = random.cloud(16, {3, 2, 0.5}, {0, 0, 0});
  const auto hills = [&] {
    Cloud cloud(3, 8000);
    for (int i = 0; i < cloud.cols(); ++i) {
      const double x = random.uniform(-3, 3), y = random.uniform(-2, 2);
      double z = 0;
      for (int top = 0; top < tops.cols(); ++top)
        z += tops(2, top) * std::exp(-8 * (std::pow(x - tops(0, top), 2) + std::pow(y - tops(1, top), 2)));
      cloud.col(i) = Vector3d(x, y, z).cast<float>();
    }
    return cloud;
  };
  const Cloud target = cut(hills(), -1, 1), part = cut(hills(), 1, 1);
  for (int trial = 0; trial < 3; ++trial) {
    SCOPED_TRACE(trial);
    const Isometry3d truth = random.motion(5);
    const Cloud source = moved(part, truth.inverse());
    const PoseSearchResult found = poses.search(viewOf(source), viewOf(target));
    ASSERT_NO_FATAL_FAILURE(expectFound(found, truth, source, 4, 0.3));
    EXPECT_GT(found.poses[0].support, 10U);
  }
}

TEST_F(PoseSearching, TriesHeadingsAloneWhereNothingTilts)
{
  const Cloud target = scene(random, 5000);
  for (const Motions motions : {Motions::Yaw, Motions::Planar}) {
    SCOPED_TRACE(toString(motions));
    poses.setMotions(motions);
    for (const double angle : {2.0, -1.2}) {
      const Isometry3d tilt = motion({1, 2, 0}, 0.2, {0, 0, 0.3});
      const Isometry3d truth = motion({0, 0, 1}, angle, {1, -2, motions == Motions::Yaw ? 0.5 : 0}) * tilt;
      const Cloud source = moved(scene(random, 5000), truth.inverse());
      const PoseSearchResult found = poses.search(viewOf(source), viewOf(target), transformOf(tilt));
      ASSERT_FALSE(found.poses.empty());
      EXPECT_LE(found.starts, 73U);
      EXPECT_LT(degreesOff(found.poses[0].transform, truth), 3);
      EXPECT_LT(metresOff(found.poses[0].transform, truth, source), 0.2);
      // The guess's tilt, and for a plane its height.
      const RigidTransform done = compose(found.poses[0].transform, inverse(transformOf(tilt)));
      EXPECT_NEAR(done.rotation[8], 1, 1e-6);
      EXPECT_NEAR(done.translation[2], motions == Motions::Yaw ? 0.5 : 0, motions == Motions::Yaw ? 0.1 : 1e-6);
    }
  }
}

/// Of surfaces on each other, plainly in part.
PoseCandidate posed(double score, double near)
{
  PoseCandidate pose;
  pose.score = score;
  pose.quality.spacing = 1;
  pose.quality.after = {near, near};
  pose.quality.median_distance = 0.5;
  pose.quality.concentration = 0.9;
  pose.quality.surfaces = SurfaceFit{0.9, 1, 0.1, 0.1, 0.1};
  return pose;
}

TEST(PoseSearchResult, HasARivalWhereAnotherPoseFitsAsWellOrPlainly)
{
  const auto rivalOf = [](const PoseCandidate& best, const std::vector<PoseCandidate>& others) {
    PoseSearchResult result;
    result.poses = others;
    result.poses.insert(result.poses.begin(), best);
    const PoseCandidate* rival = result.rival();
    return rival ? rival - result.poses.data() : 0;
  };
  EXPECT_FALSE(PoseSearchResult().isAmbiguous());
  EXPECT_EQ(rivalOf(posed(0.9, 0.8), {}), 0);
  EXPECT_EQ(rivalOf(posed(0.9, 0.8), {posed(0.5, 0.6)}), 1);                  // plainly: its fit is 0.75 of the best's
  EXPECT_EQ(rivalOf(posed(0.9, 0.8), {posed(0.5, 0.5)}), 0);                  // 0.63
  EXPECT_EQ(rivalOf(posed(0.9, 0.8), {posed(0.6, 0.6), posed(0.5, 0.7)}), 2); // the better of two
  PoseCandidate crossing = posed(0.5, 0.7);
  crossing.quality.surfaces->alike = 0.5; // not good by itself
  EXPECT_EQ(rivalOf(posed(0.9, 0.8), {crossing}), 0);
  crossing.score = 0.85; // but nearly as well
  EXPECT_EQ(rivalOf(posed(0.9, 0.8), {crossing}), 1);
  crossing.quality.median_distance = 1; // for the voxels, not for the points
  EXPECT_EQ(rivalOf(posed(0.9, 0.8), {crossing}), 0);
  EXPECT_EQ(rivalOf(posed(0.99, 0.99), {posed(0.95, 0.9)}), 0); // where the best explains all
  EXPECT_EQ(rivalOf(posed(0.99, 0.99), {posed(0.95, 0.98)}), 1);
  PoseCandidate supported = posed(0.9, 0.8), other = posed(0.9, 0.8);
  supported.support = 70;
  other.support = 31; // more than half as many, but for the ten that are chance
  EXPECT_EQ(rivalOf(supported, {other}), 1);
  other.support = 30;
  EXPECT_EQ(rivalOf(supported, {other}), 0);
  PoseCandidate unmeasured;
  unmeasured.score = 0.5;
  EXPECT_EQ(rivalOf(unmeasured, {unmeasured}), 1);
}

TEST_F(PoseSearching, SaysWhatIsSymmetric)
{
  // A box: half a turn about any axis is itself.
  const auto box = [this](std::size_t n) {
    Cloud cloud(3, n);
    for (int i = 0; i < cloud.cols(); ++i) {
      Vector3d point(random.uniform(-3, 3), random.uniform(-2, 2), random.uniform(-1, 1));
      const int face = i % 3;
      point[face] = std::copysign(3 - face, point[face]);
      cloud.col(i) = point.cast<float>();
    }
    return cloud;
  };
  const Cloud target = box(5000), source = moved(box(5000), random.motion(3));
  EXPECT_TRUE(poses.search(viewOf(source), viewOf(target)).isAmbiguous());
}

TEST_F(PoseSearching, SaysThatHalvesOfARoomFitInTwoWays)
{
  // Half a turn puts one half onto the other, and more points onto each other than the truth does.
  const Isometry3d truth = motion({0, 0, 1}, 0.09, {0.25, 0.15, 0});
  for (const double shared : {1.2, 2.0}) {
    SCOPED_TRACE(shared);
    const Cloud target = cut(room(random, 12000), -1, shared);
    const Cloud source = moved(cut(room(random, 12000), 1, shared), truth.inverse());
    const PoseSearchResult found = poses.search(viewOf(source), viewOf(target));
    EXPECT_TRUE(found.isAmbiguous());
    EXPECT_TRUE(std::any_of(found.poses.begin(), found.poses.end(), [&](const PoseCandidate& pose) {
      return degreesOff(pose.transform, truth) < 2 && metresOff(pose.transform, truth, source) < 0.1;
    })) << "the guess leads to it";
  }
  // All of it fits in one.
  const PoseSearchResult whole =
      poses.search(viewOf(moved(room(random, 12000), truth.inverse())), viewOf(room(random, 12000)));
  ASSERT_FALSE(whole.poses.empty());
  EXPECT_LT(degreesOff(whole.poses[0].transform, truth), 2);
  EXPECT_FALSE(whole.isAmbiguous());
}

TEST_F(PoseSearching, HasTheSameBitsHoweverManyRunAtATime)
{
  const Cloud target = scene(random, 3000), source = moved(scene(random, 3000), random.motion(3));
  const PoseSearchResult first = poses.search(viewOf(source), viewOf(target));
  for (const unsigned lanes : {1U, 8U}) {
    poses.setLanes(lanes);
    const PoseSearchResult again = poses.search(viewOf(source), viewOf(target));
    ASSERT_EQ(again.poses.size(), first.poses.size());
    for (std::size_t i = 0; i < first.poses.size(); ++i) {
      EXPECT_EQ(again.poses[i].transform.rotation, first.poses[i].transform.rotation);
      EXPECT_EQ(again.poses[i].transform.translation, first.poses[i].transform.translation);
      EXPECT_EQ(again.poses[i].score, first.poses[i].score);
    }
  }
}

TEST_F(PoseSearching, FarFromTheOriginAndInOtherUnitsIsTheSame)
{
  for (const double unit : {1e-6, 1e6}) {
    SCOPED_TRACE(unit);
    const Cloud target = (scene(random, 4000) * static_cast<float>(unit)).eval();
    Isometry3d truth = random.motion(1);
    truth.translation() *= unit;
    const Cloud source = moved((scene(random, 4000) * static_cast<float>(unit)).eval(), truth.inverse());
    const PoseSearchResult found = poses.search(viewOf(source), viewOf(target));
    ASSERT_FALSE(found.poses.empty());
    EXPECT_LT(degreesOff(found.poses[0].transform, truth), 3);
    EXPECT_LT(metresOff(found.poses[0].transform, truth, source), 0.2 * unit);
  }
  const Cloud target = (scene(random, 4000).colwise() + Eigen::Vector3f(4e3, 5e4, 100)).eval();
  const Isometry3d truth = Eigen::Translation3d(4e3, 5e4, 100) * random.motion(1);
  const Cloud source = moved(scene(random, 4000), truth.inverse() * Eigen::Translation3d(4e3, 5e4, 100));
  const PoseSearchResult found = poses.search(viewOf(source), viewOf(target));
  ASSERT_FALSE(found.poses.empty());
  EXPECT_LT(metresOff(found.poses[0].transform, truth, source), 0.2);
}

TEST_F(PoseSearching, TellsHowFarItIs)
{
  std::size_t last = 0, of = 0;
  poses.setProgress([&](std::size_t done, std::size_t all) {
    EXPECT_EQ(done, last + 1);
    EXPECT_TRUE(of == 0 || all <= of);
    last = done;
    of = all;
  });
  const Cloud plain = scene(random, 1000);
  poses.search(viewOf(plain), viewOf(plain));
  EXPECT_GT(last, 1U);
  EXPECT_EQ(last, of);
  last = of = 0;
  const auto ball = [this] { return random.directions(1000); }; // which no feature tells how to turn
  poses.search(viewOf(ball()), viewOf(ball()));
  EXPECT_GT(last, 50U);
  EXPECT_EQ(last, of);
}

TEST_F(PoseSearching, PointsThatRepeatCountOnce)
{
  const Cloud once = scene(random, 900), target = scene(random, 3000);
  Cloud source(3, 20 * once.cols());
  for (int i = 0; i < source.cols(); ++i)
    source.col(i) = once.col(i % once.cols());
  const PoseSearchResult found = poses.search(viewOf(source), viewOf(target));
  ASSERT_FALSE(found.poses.empty());
  EXPECT_GT(found.poses[0].score, 0.5);
}

TEST_F(PoseSearching, FlatCloudsAreFoundByTheirOutline)
{
  const auto outline = [this](std::size_t n) {
    Cloud cloud(3, n);
    for (int i = 0; i < cloud.cols(); ++i) {
      const double s = random.uniform(0, 4);
      const Vector3d point = s < 2   ? Vector3d(2 * s, 0, 0)
                             : s < 3 ? Vector3d(4, 3 * (s - 2), 0)
                                     : Vector3d(4 - 2 * (s - 3), 3, 0);
      cloud.col(i) = point.cast<float>();
    }
    return cloud;
  };
  poses.setMotions(Motions::Planar);
  const Isometry3d truth = motion({0, 0, 1}, 2, {1, -2, 0});
  const Cloud target = outline(1000), source = moved(outline(1000), truth.inverse());
  const PoseSearchResult found = poses.search(viewOf(source), viewOf(target));
  ASSERT_FALSE(found.poses.empty());
  EXPECT_LT(degreesOff(found.poses[0].transform, truth), 3);
  EXPECT_LT(metresOff(found.poses[0].transform, truth, source), 0.1);
}

TEST_F(PoseSearching, HasNothingForTooFewPoints)
{
  const Cloud target = scene(random, 1000), few = target.leftCols(5);
  Cloud at_one_place(3, 100);
  at_one_place.setOnes();
  EXPECT_TRUE(poses.search(viewOf(few), viewOf(target)).poses.empty());
  EXPECT_TRUE(poses.search(viewOf(target), viewOf(few)).poses.empty());
  EXPECT_TRUE(poses.search(viewOf(at_one_place), viewOf(target)).poses.empty());
  EXPECT_FALSE(poses.search(viewOf(few), viewOf(target)).isAmbiguous());
  // In other units no more than a place.
  const Cloud tiny = target * 1e-7F;
  for (const PoseCandidate& pose : poses.search(viewOf(tiny), viewOf(target)).poses)
    EXPECT_GT(pose.score, 0);
  EXPECT_TRUE(poses.search(viewOf(target), viewOf(at_one_place)).poses.empty());
}

} // namespace
} // namespace pcl_gpu_icp::test
