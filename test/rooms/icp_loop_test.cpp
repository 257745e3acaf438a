#include <pcl_gpu_icp/icp_loop.h>

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

using namespace pcl_gpu_icp;

namespace {

RigidTransform turnAboutZ(double angle, double x, double y, double z)
{
  RigidTransform pose;
  pose.rotation = {std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1};
  pose.translation = {x, y, z};
  return pose;
}

/// Approaches the identity from poses turned about z, each degree of freedom at a rate of its own, as ICP does that
/// slides along a surface.
class Sliding : public IcpSteps {
public:
  bool match(const RigidTransform& pose) override
  {
    visited.push_back(pose);
    angle_ = std::atan2(pose.rotation[3], pose.rotation[0]);
    at_ = pose.translation;
    return true;
  }
  double error() const override { return angle_ * angle_ + at_[0] * at_[0] + at_[1] * at_[1] + at_[2] * at_[2]; }
  RigidTransform estimateIncrement(const RigidTransform& pose) override
  {
    const RigidTransform next = turnAboutZ(0.97 * angle_, 0.95 * at_[0], 0.9 * at_[1], 0.5 * at_[2]);
    return compose(next, inverse(pose));
  }
  bool finished(const RigidTransform& /*increment*/, const RigidTransform& /*pose*/) override
  {
    return error() < 1e-16 || visited.size() >= 1000;
  }

  std::vector<RigidTransform> visited;

private:
  double angle_ = 0;
  std::array<double, 3> at_{};
};

const RigidTransform guess = turnAboutZ(0.3, 0.5, -0.4, 0.2);

} // namespace

TEST(IcpLoop, PlainStepsReachTheFixedPoint)
{
  Sliding steps;
  iterate(steps, guess);
  EXPECT_LT(steps.error(), 1e-16);
  EXPECT_GT(steps.visited.size(), 400U); // 0.97^n < 1e-8 / 0.3
}

TEST(IcpLoop, AccelerationReachesTheSameFixedPointInFewSteps)
{
  Sliding steps;
  const RigidTransform end = iterate(steps, guess, Lever{{0, 0, 0}, 1});
  EXPECT_LT(steps.error(), 1e-16);
  EXPECT_LT(steps.visited.size(), 20U);
  EXPECT_NEAR(end.rotation[1], 0, 1e-7);
  EXPECT_NEAR(end.rotation[0] * end.rotation[4] - end.rotation[1] * end.rotation[3], 1, 1e-12);
}

TEST(IcpLoop, AccelerationIsTakenBackWhereTheErrorRises)
{
  /// Every pose that plain steps do not lead to is worse.
  class Suspicious : public Sliding {
  public:
    bool match(const RigidTransform& pose) override
    {
      const bool plain = visited.empty() || pose.translation == expected_.translation;
      Sliding::match(pose);
      error_ = plain ? Sliding::error() : 1e9;
      return true;
    }
    double error() const override { return error_; }
    bool finished(const RigidTransform& increment, const RigidTransform& pose) override
    {
      ends.push_back(pose.translation);
      expected_ = pose;
      return Sliding::finished(increment, pose);
    }
    std::vector<std::array<double, 3>> ends;

  private:
    double error_ = 0;
    RigidTransform expected_;
  };
  Suspicious accelerated, plain;
  iterate(accelerated, guess, Lever{{0, 0, 0}, 1});
  iterate(plain, guess);
  ASSERT_GT(accelerated.visited.size(), accelerated.ends.size());
  for (std::size_t i = 0; i < std::min(plain.ends.size(), accelerated.ends.size()); ++i)
    EXPECT_EQ(accelerated.ends[i], plain.ends[i]) << "step " << i;
}

TEST(IcpLoop, TooFewMatchesEndItOnlyWhereAPlainStepLed)
{
  class Patchy : public Sliding {
  public:
    bool match(const RigidTransform& pose) override
    {
      Sliding::match(pose);
      return visited.size() != 3; // the first extrapolation
    }
  };
  Patchy steps;
  iterate(steps, guess, Lever{{0, 0, 0}, 1});
  EXPECT_LT(steps.error(), 1e-16);

  class Blind : public Sliding {
  public:
    bool match(const RigidTransform& /*pose*/) override { return false; }
  };
  Blind blind;
  EXPECT_EQ(iterate(blind, guess, Lever{{0, 0, 0}, 1}).translation, guess.translation);
  EXPECT_EQ(iterate(blind, guess).translation, guess.translation);
}

TEST(IcpLoop, ACloudAtOnePlaceIsNotAccelerated)
{
  Sliding steps, plain;
  iterate(steps, guess, Lever{{0, 0, 0}, 0});
  iterate(plain, guess);
  EXPECT_EQ(steps.visited.size(), plain.visited.size());
}

TEST(IcpLoop, TheLeverIsTheRootMeanSquareRadius)
{
  const float points[] = {1, 2, 3, 3, 2, 3, 2, 1, 3, 2, 3, 3};
  const Lever lever = leverOf({points, 4, 3 * sizeof(float)});
  EXPECT_EQ(lever.centre, (std::array<double, 3>{2, 2, 3}));
  EXPECT_DOUBLE_EQ(lever.length, 1);
  EXPECT_EQ(leverOf({points, 0, 3 * sizeof(float)}).length, 0);
}
