// Matcher: on every iteration the match of every source point is the nearest target point, whatever was found before.
// Compared with looking at every target point in double, on every device, kernel shape and precision, with either
// search.
#include "device_cases.h"
#include "engine/matcher_internals.h"
#include "generous_share.h"
#include "reference.h"

#include <cmath>
#include <functional>
#include <limits>

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Search = CorrespondenceSearch;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

struct MatcherCase {
  DeviceCase device;
  Search search = Search::DeviceKdTree;

  std::string name() const { return device.name() + (search == Search::DeviceKdTree ? "_DeviceTree" : "_HostTree"); }
};

std::ostream& operator<<(std::ostream& stream, const MatcherCase& matcher_case)
{
  return stream << matcher_case.name();
}

std::vector<MatcherCase> matcherCases()
{
  std::vector<MatcherCase> cases;
  for (const DeviceCase& device : kernelCases()) {
    if (device.searches())
      cases.push_back({device, Search::DeviceKdTree});
    cases.push_back({device, Search::PclKdTree});
  }
  return cases;
}

double largestCoordinate(const Cloud& cloud)
{
  double largest = 0;
  for (int i = 0; i < cloud.cols(); ++i)
    if (cloud.col(i).allFinite())
      largest = std::max<double>(largest, cloud.col(i).cwiseAbs().maxCoeff());
  return largest;
}

/// A matcher together with the host index that it may need.
class Rig {
public:
  explicit Rig(const MatcherCase& matcher_case)
  : search_(matcher_case.search)
  , matcher_(makeMatcher(matcher_case.device.device, matcher_case.device.traits, matcher_case.device.precision))
  {
  }

  void set(const Cloud& source, const Cloud& target)
  {
    source_ = source;
    target_ = target;
    if (search_ == Search::PclKdTree) {
      const auto index = std::make_shared<search::NearestIndex>();
      index->build(viewOf(target_));
      matcher_.setTarget(matcher_.makeTarget(index));
    }
    else
      matcher_.setTarget(matcher_.makeTarget(viewOf(target_)));
    matcher_.setSource(viewOf(source_));
  }

  Matches match(const Isometry3d& pose, float limit = infinity)
  {
    pose_ = pose;
    limit_ = limit;
    return matcher_.match(transformOf(pose), limit);
  }

  /// Compares the last matches with looking at every target point.
  void expectNearest(const Matches& matches)
  {
    const auto found = matcher_.correspondences(transformOf(pose_));
    std::vector<std::int32_t> match(source_.cols(), -1);
    for (std::size_t i = 0; i < found.size(); ++i) {
      ASSERT_TRUE(i == 0 || found[i - 1].source < found[i].source);
      match[found[i].source] = found[i].target;
    }
    ASSERT_EQ(matches.increment.pairs, found.size());
    // The device moves the points in float32.
    const double reach = largestCoordinate(source_) * 2 + largestCoordinate(target_) + pose_.translation().norm();
    const double rounding = 4 * std::numeric_limits<float>::epsilon() * reach;
    double sum = 0;
    for (int i = 0; i < source_.cols(); ++i) {
      if (!source_.col(i).allFinite()) {
        ASSERT_EQ(match[i], -1);
        continue;
      }
      const Vector3d p = pose_ * source_.col(i).cast<double>();
      double nearest = std::numeric_limits<double>::infinity();
      for (int j = 0; j < target_.cols(); ++j)
        if (target_.col(j).allFinite())
          nearest = std::min(nearest, (target_.col(j).cast<double>() - p).norm());
      const double limit = std::sqrt(double(limit_));
      if (match[i] < 0) {
        ASSERT_GE(nearest * (1 + 1e-6) + rounding, limit) << "point " << i << " has no match";
        continue;
      }
      const double distance = (target_.col(match[i]).cast<double>() - p).norm();
      ASSERT_LE(distance, nearest * (1 + 1e-6) + rounding) << "point " << i << " has a nearer one";
      ASSERT_LE(distance, limit * (1 + 1e-6) + rounding) << "point " << i << " is matched beyond the limit";
      sum += distance * distance;
    }
    if (!found.empty()) {
      const double mean = sum / double(found.size());
      ASSERT_NEAR(matches.mean_squared_distance, mean, 1e-5 * mean + 4 * rounding * (std::sqrt(mean) + rounding));
    }
  }

  void expectNearestAt(const Isometry3d& pose, float limit = infinity)
  {
    const Matches matches = match(pose, limit);
    expectNearest(matches);
  }

  Matcher& matcher() { return matcher_; }

private:
  Search search_;
  Matcher matcher_;
  Cloud source_, target_;
  Isometry3d pose_ = Isometry3d::Identity();
  float limit_ = infinity;
};

/// Clouds of every kind, of 1 to `most` points.
Cloud anyCloud(Random& random, std::size_t most)
{
  const std::size_t n = random.count(1, most);
  switch (random.count(0, 7)) {
  case 0:
    return random.cloud(n, {5, 5, 0}, {0, 0, 1});
  case 1:
    return random.cloud(n, {5, 0, 0}, {1, 2, 3});
  case 2:
    return random.cloud(n, {0, 0, 0}, {1, 2, 3});
  case 3: {
    // A lattice: ties everywhere, and coincident points.
    Cloud cloud = random.cloud(n, {2.4, 2.4, 1.4}, {0, 0, 0});
    return cloud.array().round().matrix();
  }
  case 4:
    return random.cloud(n, {5, 5, 5}, {4e5, 5e6, 100});
  case 5:
    return random.cloud(n, {1e-12, 1e-12, 1e-12}, {0, 0, 0});
  case 6: {
    Cloud cloud = random.cloud(n);
    for (int i = 0; i < cloud.cols(); i += 7)
      cloud(i % 3, i) = i % 2 ? not_a_number : infinity;
    return cloud;
  }
  default:
    return random.cloud(n);
  }
}

} // namespace

class Matching : public testing::TestWithParam<MatcherCase> {
protected:
  std::size_t affordable(std::size_t n) const { return GetParam().device.affordable(n); }
  Rig rig_{GetParam()};
};

TEST_P(Matching, EveryCorrespondenceOfEveryIterationIsTheNearest)
{
  // Six iterations of each.
  const unsigned cases = unsigned(affordable(30'000) / 150);
  for (unsigned seed = 0; seed < cases; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const Cloud target = anyCloud(random, 300);
    // The source lies where the target does, but is another cloud.
    Cloud source = target;
    const double size = largestCoordinate(target - target.col(0).replicate(1, target.cols()));
    for (int i = 0; i < source.cols(); ++i)
      source.col(i) += (random.direction() * random.uniform(0, 0.2) * std::min(size, 10.0)).cast<float>();
    rig_.set(source, target);
    const float limit = random.count(0, 2) == 0 ? float(random.uniform(0, 0.1) * size * size) : infinity;
    const Vector3d centre = target.col(0).allFinite() ? Vector3d(target.col(0).cast<double>()) : Vector3d(0, 0, 0);
    double step = std::min(size, 10.0) * random.uniform(0.001, 0.5);
    Isometry3d pose = Isometry3d::Identity();
    for (int iteration = 0; iteration < 6; ++iteration) {
      rig_.expectNearestAt(pose, limit);
      if (HasFatalFailure())
        return;
      // Shrinking steps, and now and then a huge one, none, or back to the start.
      const auto kind = random.count(0, 9);
      if (kind == 0)
        pose = Isometry3d::Identity();
      else if (kind != 1) {
        const double length = kind == 2 ? 10 * size : step;
        pose = Eigen::Translation3d(centre + random.direction() * length) *
               Eigen::AngleAxisd(length / (size + 1e-30) * 0.3, random.direction()) * Eigen::Translation3d(-centre) *
               pose;
        step *= random.uniform(0.05, 1);
      }
    }
  }
}

TEST_P(Matching, EverySizeAroundABlockAndALevelOfTheTree)
{
  Random random(1);
  for (const std::size_t n : {1, 2, 15, 16, 17, 255, 256, 257, 511, 513, 4095, 4097}) {
    if (n > affordable(5000))
      break;
    SCOPED_TRACE(std::to_string(n) + " points");
    rig_.set(random.cloud(std::min<std::size_t>(n, 600)), random.cloud(n));
    rig_.expectNearestAt(Isometry3d::Identity());
    rig_.expectNearestAt(motion({0, 1, 0}, 0.01, {0.05, 0, 0}));
    if (HasFatalFailure())
      return;
    rig_.set(random.cloud(n), random.cloud(std::min<std::size_t>(n, 600)));
    rig_.expectNearestAt(Isometry3d::Identity());
    rig_.expectNearestAt(motion({0, 1, 0}, 0.01, {0.05, 0, 0}), 0.25F);
    if (HasFatalFailure())
      return;
  }
}

TEST_P(Matching, MorePointsThanTheHostSearchesForAtOnce)
{
  Random random(8);
  rig_.set(random.cloud(affordable(40000)), random.cloud(60));
  rig_.expectNearestAt(Isometry3d::Identity());
  EXPECT_EQ(rig_.match(Isometry3d::Identity()).searched, 0U);
  rig_.expectNearestAt(motion({0, 1, 0}, 0.3, {0.5, 0, 0}));
}

TEST_P(Matching, PointsOnBisectorsChangeSidesInTime)
{
  // Each source point half-way between two target points, and moved to and fro by less and less.
  constexpr int n = 64;
  Cloud target(3, n + 1), source(3, n);
  for (int i = 0; i <= n; ++i)
    target.col(i) << float(i), 0, 0;
  for (int i = 0; i < n; ++i)
    source.col(i) << float(i) + 0.5F, 0.25F, 0;
  rig_.set(source, target);
  double step = 0.3;
  for (int iteration = 0; iteration < 40; ++iteration, step *= -0.7) {
    rig_.expectNearestAt(motion({0, 0, 1}, 0, {step, 0, 0}));
    if (HasFatalFailure())
      return;
  }
}

TEST_P(Matching, SearchesForFewerAndFewerPointsAsStepsShrink)
{
  Random random(2);
  const Cloud target = random.cloud(affordable(1000));
  const Cloud source = random.cloud(affordable(900));
  rig_.set(source, target);
  std::size_t searched = 0;
  double x = 0, step = 0.2;
  for (int iteration = 0; iteration < 14; ++iteration, x += step, step *= 0.5) {
    const Matches matches = rig_.match(motion({0, 0, 1}, 0, {x, 0, 0}));
    EXPECT_LE(matches.searched, std::size_t(source.cols()));
    EXPECT_TRUE(iteration > 0 || matches.searched == std::size_t(source.cols()));
    searched = matches.searched;
    rig_.expectNearest(matches);
  }
  EXPECT_LT(searched, std::size_t(source.cols()) / 20);
  EXPECT_EQ(rig_.match(motion({0, 0, 1}, 0, {x, 0, 0})).searched, rig_.match(motion({0, 0, 1}, 0, {x, 0, 0})).searched);
}

TEST_P(Matching, WhatWasFoundBeforeDoesNotChangeABit)
{
  Random random(3);
  const Cloud target = random.cloud(affordable(2000)), source = random.cloud(affordable(1900));
  rig_.set(source, target);
  Rig fresh(GetParam());
  double x = 0.5;
  for (int iteration = 0; iteration < 8; ++iteration, x *= 0.3) {
    const Isometry3d pose = motion({0, 0, 1}, 0.1 * x, {x, -x, 0});
    const Matches experienced = rig_.match(pose, 1.0F);
    fresh.set(source, target);
    const Matches naive = fresh.match(pose, 1.0F);
    EXPECT_EQ(experienced.mean_squared_distance, naive.mean_squared_distance);
    EXPECT_EQ(experienced.increment.transform.rotation, naive.increment.transform.rotation);
    EXPECT_EQ(experienced.increment.transform.translation, naive.increment.transform.translation);
    EXPECT_EQ(experienced.increment.pairs, naive.increment.pairs);
  }
}

TEST_P(Matching, OnAShareOfTheDeviceTheSameBits)
{
  Random random(9);
  const Cloud target = random.cloud(affordable(2000)), source = random.cloud(affordable(1900));
  const auto run = [&](const std::shared_ptr<DeviceShare>& share) {
    rig_.matcher().setShare(share);
    rig_.set(source, target);
    rig_.match(Isometry3d::Identity(), 1.0F);
    return rig_.match(motion({0, 0, 1}, 0.01, {0.02, 0, 0}), 1.0F);
  };
  const Matches alone = run(nullptr);
  for (const std::size_t capacity : {1, 3, 300, 100'000}) {
    const auto share = std::make_shared<GenerousShare>(capacity);
    const Matches shared = run(share);
    EXPECT_EQ(shared.mean_squared_distance, alone.mean_squared_distance);
    EXPECT_EQ(shared.searched, alone.searched);
    EXPECT_EQ(shared.increment.transform.rotation, alone.increment.transform.rotation);
    EXPECT_EQ(shared.increment.transform.translation, alone.increment.transform.translation);
    ASSERT_FALSE(share->log.empty());
    EXPECT_EQ(share->log.back(), "release");
    // Launches for more than the capacity are whole work-groups in passes.
    const std::size_t group =
        GetParam().device.traits.shape == opencl::Shape::Chunked ? 1 : GetParam().device.traits.work_group_size;
    for (const std::string& entry : share->log)
      EXPECT_TRUE(entry == "release" || std::stoull(entry.substr(entry.find(' '))) <= std::max(capacity, group));
  }
}

TEST_P(Matching, MatchersShareATarget)
{
  Random random(10);
  const Cloud target = random.cloud(affordable(1000)), source = random.cloud(affordable(500));
  rig_.set(source, target);
  const Matches alone = rig_.match(Isometry3d::Identity());
  Matcher first = makeMatcher(GetParam().device.device, GetParam().device.traits, GetParam().device.precision);
  Matcher second = makeMatcher(GetParam().device.device, GetParam().device.traits, GetParam().device.precision);
  const auto index = std::make_shared<search::NearestIndex>();
  index->build(viewOf(target));
  const auto shared =
      GetParam().search == Search::PclKdTree ? first.makeTarget(index) : first.makeTarget(viewOf(target));
  for (Matcher* matcher : {&first, &second}) {
    matcher->setTarget(shared);
    matcher->setSource(viewOf(source));
    const Matches matches = matcher->match({}, infinity);
    EXPECT_EQ(matches.increment.transform.rotation, alone.increment.transform.rotation);
    EXPECT_EQ(matches.increment.transform.translation, alone.increment.transform.translation);
  }
}

TEST_P(Matching, IncrementIsThatOfTheReference)
{
  Random random(4);
  const Cloud target = random.cloud(affordable(1500));
  const Isometry3d pose = motion({0, 1, 1}, 0.3, {1, 2, 3});
  const Isometry3d error = motion({1, 0, 0}, 0.002, {0.01, 0, -0.01});
  const Cloud source = moved(target, pose.inverse() * error.inverse());
  rig_.set(source, target);
  // Every point's nearest is its own image, so that the pairs are known.
  const Matches matches = rig_.match(pose);
  const Cloud at_pose = moved(source, pose);
  EXPECT_LT(rmsDifference(isometryOf(matches.increment.transform), error, at_pose),
            GetParam().device.precision == Precision::Double ? 2e-6 : 2e-5);
  EXPECT_LT(rig_.matcher().meanSquaredDistance(transformOf(error * pose)), 1e-10);
}

TEST_P(Matching, CoincidentTargetPointsAreOne)
{
  Random random(5);
  Cloud target(3, 500);
  target << random.cloud(100), Vector3d(1, -2, 3).cast<float>().replicate(1, 400);
  rig_.set(random.cloud(64), target);
  rig_.expectNearestAt(Isometry3d::Identity());
  EXPECT_EQ(rig_.matcher().targetSize(), 101U);
  const auto found = rig_.matcher().correspondences({});
  for (const Correspondence& c : found)
    EXPECT_LE(c.target, 100) << "the first of those that coincide";
}

TEST_P(Matching, NothingToMatchIsNotAnError)
{
  Random random(6);
  const Cloud some = random.cloud(20), none(3, 0);
  for (const auto& [source, target] : {std::pair{some, none}, std::pair{none, some}, std::pair{none, none}}) {
    rig_.set(source, target);
    const Matches matches = rig_.match(Isometry3d::Identity());
    EXPECT_EQ(matches.increment.pairs, 0U);
    EXPECT_EQ(matches.increment.degeneracy, Degeneracy::Empty);
    EXPECT_EQ(matches.mean_squared_distance, 0);
    EXPECT_TRUE(rig_.matcher().correspondences({}).empty());
  }
  rig_.set(some, some);
  EXPECT_EQ(rig_.match(motion({0, 0, 1}, 0, {100, 0, 0}), 1.0F).increment.pairs, 0U);
}

TEST_P(Matching, TheLimitItselfIsWithinReachAndTheNextNumberIsNot)
{
  Cloud source(3, 1), target(3, 2);
  source << 0, 0, 0;
  target << 0.5, 8, 0, 0, 0, 0;
  const float below = std::nextafter(0.25F, 0.0F), limits[] = {below, 0.25F, below, 1, 0.25F, below};
  rig_.set(source, target);
  for (const float limit : limits)
    EXPECT_EQ(rig_.match(Isometry3d::Identity(), limit).increment.pairs, limit == below ? 0U : 1U) << limit;
}

TEST_P(Matching, DistancesAtTheLimitsOfFloat)
{
  Random random(7);
  for (const double scale : {1e-18, 1e-15, 1e15, 5e17}) {
    SCOPED_TRACE(scale);
    const Cloud target = random.cloud(200, Vector3d::Constant(scale), {0, 0, 0});
    rig_.set(random.cloud(100, Vector3d::Constant(scale), {0, 0, 0}), target);
    for (const double x : {0.0, 0.1, 0.11, 0.111}) {
      rig_.expectNearestAt(motion({0, 0, 1}, 0, {x * scale, 0, 0}));
      if (HasFatalFailure())
        return;
    }
  }
  // Beyond what takes part.
  rig_.set(random.cloud(10, {1, 1, 1}, {3e19, 0, 0}), random.cloud(10, {1, 1, 1}, {-3e19, 0, 0}));
  EXPECT_EQ(rig_.match(Isometry3d::Identity()).increment.pairs, 0U);
}

// What was not searched for at one pose, because it overflowed there, must not be read at another.
TEST_P(Matching, PointsThatOverflowAtOnePoseAreFoundAtAnother)
{
  Random random(8);
  const Cloud target = random.cloud(200);
  Cloud source = random.cloud(100);
  source.col(3).setConstant(9e17F);
  for (const double far : {2e18, 1e19, 2e19, 3e38, 1e300}) {
    SCOPED_TRACE(far);
    rig_.set(source, target);
    for (const double x : {far, 0.0, -far, 0.1, far, 0.11}) {
      if (std::abs(x) > 1)
        rig_.match(motion({0, 0, 1}, 0.1, {x, 0, 0}));
      else
        rig_.expectNearestAt(motion({0, 0, 1}, 0.1, {x, 0, 0}));
      if (HasFatalFailure())
        return;
    }
  }
}

TEST_P(Matching, LimitsThatAreNoneAreRefused)
{
  Random random(9);
  rig_.set(random.cloud(20), random.cloud(20));
  for (const float limit : {-1.0F, -infinity, std::nanf("")})
    EXPECT_THROW(rig_.match(Isometry3d::Identity(), limit), InvalidArgument);
  EXPECT_EQ(rig_.match(Isometry3d::Identity(), 0.0F).increment.pairs, 0U);
  EXPECT_EQ(rig_.match(Isometry3d::Identity()).increment.pairs, 20U);
}

TEST_P(Matching, AnswersTheSameFromAnyNumberOfThreads)
{
  Random random(8);
  const Cloud source = random.cloud(affordable(3000)), target = random.cloud(affordable(3000));
  const auto run = [&](unsigned threads) {
    rig_.matcher().setNumberOfThreads(threads);
    rig_.set(source, target);
    return rig_.match(Isometry3d::Identity());
  };
  const Matches alone = run(1);
  for (const unsigned threads : {2, 3, 8}) {
    const Matches together = run(threads);
    EXPECT_EQ(together.mean_squared_distance, alone.mean_squared_distance);
    EXPECT_EQ(together.increment.transform.rotation, alone.increment.transform.rotation);
  }
}

INSTANTIATE_TEST_SUITE_P(, Matching, testing::ValuesIn(matcherCases()), nameOf<MatcherCase>);

TEST(MeanSquaredDistance, IsThatOfTheCorrespondences)
{
  Cloud source(3, 2), target(3, 2);
  source << 0, 1, 0, 0, 0, 0;
  target << 3, 1, 0, 0, 0, 1;
  EXPECT_DOUBLE_EQ(meanSquaredDistance({{0, 0, 0}, {1, 1, 0}}, viewOf(source), viewOf(target), {}), (9.0 + 1.0) / 2);
  EXPECT_EQ(meanSquaredDistance({}, viewOf(source), viewOf(target), {}), 0);
}

} // namespace pcl_gpu_icp::test
