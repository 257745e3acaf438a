// What an answer must not depend on: the unit of the points, a stray point far away, limits and guesses that make no
// sense; and what it must be: a rotation, compared over the same points before and after.
#include "scenes.h"

#include <pcl_gpu_icp/icp.h>

#include <pcl/registration/correspondence_rejection_trimmed.h>
#include <pcl/registration/icp.h>
#include <pcl/search/kdtree.h>

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

using pcl::PointXYZ;
using Cloud = pcl::PointCloud<PointXYZ>;
using pcl_gpu_icp::CorrespondenceSearch;
using pcl_gpu_icp::Degeneracy;
using pcl_gpu_icp::Pipeline;
using pcl_gpu_icp::Reason;
template <typename Scalar>
using IcpOf = pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ, Scalar>;
using Icp = IcpOf<float>;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
constexpr CorrespondenceSearch searches[] = {CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree};

Cloud::Ptr scaled(const Cloud& cloud, double scale)
{
  Cloud::Ptr result(new Cloud(cloud));
  for (auto& point : *result)
    for (int axis = 0; axis < 3; ++axis)
      point.data[axis] = static_cast<float>(scale * point.data[axis]);
  return result;
}

/// A way that the increments come by.
struct Way {
  const char* name;
  bool planes;
  CorrespondenceSearch search;
  Pipeline pipeline;
};
constexpr Way ways[] = {{"points, pcl, fused", false, CorrespondenceSearch::PclKdTree, Pipeline::Fused},
                        {"points, device, fused", false, CorrespondenceSearch::DeviceKdTree, Pipeline::Fused},
                        {"points, device, staged", false, CorrespondenceSearch::DeviceKdTree, Pipeline::Staged},
                        {"planes, pcl, fused", true, CorrespondenceSearch::PclKdTree, Pipeline::Fused},
                        {"planes, device, fused", true, CorrespondenceSearch::DeviceKdTree, Pipeline::Fused},
                        {"planes, device, staged", true, CorrespondenceSearch::DeviceKdTree, Pipeline::Staged}};

template <typename Scalar>
void follow(const Way& way, IcpOf<Scalar>& icp)
{
  using Planes = pcl_gpu_icp::TransformationEstimationPointToPlaneLLS<PointXYZ, PointXYZ, Scalar>;
  icp.setCorrespondenceSearch(way.search);
  icp.setPipeline(way.pipeline);
  if (way.planes)
    icp.setTransformationEstimation(typename Planes::Ptr(new Planes));
}

class Numerics : public testing::Test {
protected:
  Cloud::Ptr target = scenes::hills<PointXYZ>(1500);
  Cloud::Ptr source = scenes::moved(*scenes::hills<PointXYZ>(1200, 2), scenes::smallMotion());

  /// \return the final transformation
  template <typename Scalar>
  Eigen::Matrix4d align(IcpOf<Scalar>& icp, const Cloud::Ptr& from, const Cloud::Ptr& onto, int iterations = 200)
  {
    icp.setInputSource(from);
    icp.setInputTarget(onto);
    icp.setMaximumIterations(iterations);
    Cloud output;
    icp.align(output);
    EXPECT_EQ(icp.getResult().message.empty(), icp.getResult().reason != Reason::NoCorrespondences);
    return icp.getFinalTransformation().template cast<double>();
  }

  template <typename Scalar>
  void expectTheSamePoseInEveryUnit(const Way& way)
  {
    IcpOf<Scalar> icp;
    follow(way, icp);
    const Eigen::Matrix4d expected = align(icp, source, target);
    EXPECT_NE(icp.getResult().reason, Reason::Iterations);
    EXPECT_LT(scenes::degreesBetween<double>(expected, scenes::smallMotion().inverse().matrix().cast<double>()), 0.5);
    const int iterations = icp.getResult().iterations;
    for (const double scale : {1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-1, 1e2, 1e5, 1e7, 1e9}) {
      SCOPED_TRACE(scale);
      Eigen::Matrix4d pose = align(icp, scaled(*source, scale), scaled(*target, scale));
      pose.topRightCorner<3, 1>() /= scale;
      EXPECT_LT(scenes::degreesBetween<double>(pose, expected), 2e-4);
      EXPECT_LT(scenes::metresBetween<double>(pose, expected), 1e-5);
      EXPECT_NE(icp.getResult().reason, Reason::Iterations);
      // To planes the end is reached at once, and what follows is up to the last digits.
      if (!way.planes) {
        EXPECT_NEAR(icp.getResult().iterations, iterations, 0.2 * iterations);
      }
      EXPECT_EQ(icp.getResult().degeneracy, Degeneracy::None);
    }
  }

  double truncatedRmse(const Eigen::Matrix4d& pose, double limit) const
  {
    pcl::search::KdTree<PointXYZ> tree;
    tree.setInputCloud(target);
    double sum = 0;
    for (const PointXYZ& point : *source) {
      const Eigen::Vector3d at =
          pose.topLeftCorner<3, 3>() * point.getVector3fMap().cast<double>() + pose.topRightCorner<3, 1>();
      pcl::Indices nearest(1);
      std::vector<float> squared(1);
      tree.nearestKSearch(PointXYZ(at.x(), at.y(), at.z()), 1, nearest, squared);
      sum += std::min<double>(squared[0], limit * limit);
    }
    return std::sqrt(sum / source->size());
  }
};

} // namespace

TEST_F(Numerics, TheSamePoseInEveryUnit)
{
  for (const Way& way : ways) {
    SCOPED_TRACE(way.name);
    expectTheSamePoseInEveryUnit<float>(way);
    expectTheSamePoseInEveryUnit<double>(way);
  }
}

TEST_F(Numerics, AnAbsoluteThresholdThatIsSetIsTakenAsItIs)
{
  Icp icp;
  EXPECT_DOUBLE_EQ(icp.getConvergeCriteria()->getAbsoluteMSE(), 1e-12);
  const Cloud::Ptr tiny_source = scaled(*source, 1e-4), tiny_target = scaled(*target, 1e-4);
  align(icp, tiny_source, tiny_target);
  const int iterations = icp.getResult().iterations;
  EXPECT_GT(iterations, 10);
  icp.getConvergeCriteria()->setAbsoluteMSE(1e-12);
  align(icp, tiny_source, tiny_target);
  EXPECT_EQ(icp.getResult().reason, Reason::AbsoluteMse);
  EXPECT_LT(icp.getResult().iterations, iterations / 2);
}

// Beyond 1e18 points are left out; before that, those that are never matched must not matter.
TEST_F(Numerics, AStrayPointTakesNoDigitsFromTheOthers)
{
  const Cloud::Ptr offset_source = scenes::moved(*source, Eigen::Affine3f(Eigen::Translation3f(1e3F, -2e3F, 10)));
  const Cloud::Ptr offset_target = scenes::moved(*target, Eigen::Affine3f(Eigen::Translation3f(1e3F, -2e3F, 10)));
  for (const Way& way : ways)
    for (const bool offset : {false, true}) {
      const auto run = [&](float stray, bool in_source, bool in_target) {
        Cloud::Ptr from(new Cloud(offset ? *offset_source : *source)),
            onto(new Cloud(offset ? *offset_target : *target));
        // Among the first, so that it is one of the samples; and on either side.
        if (in_source)
          (*from)[0] = PointXYZ(stray, -0.3F * stray, 0.1F * stray);
        else
          from->points.erase(from->begin());
        if (in_target)
          (*onto)[0] = PointXYZ(stray, 0.2F * stray, 0);
        else
          onto->points.erase(onto->begin());
        from->width = from->size();
        onto->width = onto->size();
        IcpOf<double> icp;
        follow(way, icp);
        if (in_source)
          icp.setMaxCorrespondenceDistance(1); // or it would be matched
        const Eigen::Matrix4d pose = align(icp, from, onto, 60);
        const auto& result = icp.getResult();
        const bool dropped = !(std::abs(stray) <= 1e18F);
        EXPECT_EQ(result.source_dropped, in_source && dropped ? 1U : 0U);
        EXPECT_EQ(result.target_dropped, in_target && dropped ? 1U : 0U);
        EXPECT_EQ(result.inliers, source->size() - 1);
        EXPECT_EQ(result.degeneracy, Degeneracy::None);
        EXPECT_LT(icp.getFitnessScore(1), 0.1);
        return pose;
      };
      const Eigen::Matrix4d expected = run(0, false, false);
      for (const float stray : {1e5F, -1e7F, 4e10F, 1e15F, -9e17F, 2e18F, 1e19F, 2e20F, -1e30F, 3.3e38F, infinity})
        for (const auto& [in_source, in_target] : {std::pair{true, false}, {false, true}, {true, true}}) {
          SCOPED_TRACE(std::string(way.name) + (offset ? ", offset" : "") + ", stray " + std::to_string(stray) +
                       (in_source ? " in the source" : "") + (in_target ? " in the target" : ""));
          const Eigen::Matrix4d pose = run(stray, in_source, in_target);
          EXPECT_LT(scenes::degreesBetween<double>(pose, expected), 1e-4);
          EXPECT_LT(scenes::metresBetween<double>(pose, expected), offset ? 1e-2 : 1e-5);
        }
    }
}

// At first nothing is near, and the next pose is elsewhere: what was not searched for then must not be read.
TEST_F(Numerics, PointsThatOverflowAtOnePoseAreMatchedAtAnother)
{
  for (const CorrespondenceSearch search : searches) {
    Icp icp;
    icp.setCorrespondenceSearch(search);
    const Eigen::Matrix4d expected = align(icp, source, target, 10);
    for (const float far : {3e18F, 2e19F, 3e38F}) {
      Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
      guess(0, 3) = far;
      Cloud output;
      icp.align(output, guess);
      EXPECT_FALSE(icp.hasConverged() && far > 1e19F);
      EXPECT_EQ((align(icp, source, target, 10) - expected).norm(), 0);
    }
  }
}

TEST_F(Numerics, WhatImprovedIsComparedOverTheSamePoints)
{
  source = scenes::moved(*source, Eigen::Affine3f(Eigen::AngleAxisf(0.1F, Eigen::Vector3f::UnitZ())));
  const double limit = 0.05;
  using Configure = std::function<void(IcpOf<double>&)>;
  const std::pair<const char*, Configure> cases[] = {
      {"default", [](auto&) {}},
      {"device", [](auto& icp) { icp.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree); }},
      {"caller's search",
       [](auto& icp) { icp.setSearchMethodTarget(pcl::make_shared<pcl::search::KdTree<PointXYZ>>()); }},
      {"reciprocal", [](auto& icp) { icp.setUseReciprocalCorrespondences(true); }}};
  for (const auto& [name, configure] : cases)
    for (const bool trimmed : {false, true}) {
      SCOPED_TRACE(std::string(name) + (trimmed ? ", trimmed" : ""));
      IcpOf<double> icp;
      configure(icp);
      icp.setMaxCorrespondenceDistance(limit);
      if (trimmed)
        icp.addCorrespondenceRejector(pcl::make_shared<pcl::registration::CorrespondenceRejectorTrimmed>());
      const Eigen::Matrix4d pose = align(icp, source, target, 200);
      const auto& result = icp.getResult();
      EXPECT_NEAR(result.truncated_rmse_before, truncatedRmse(Eigen::Matrix4d::Identity(), limit), 1e-6);
      // The last matches are those before the last increment.
      EXPECT_NEAR(result.truncated_rmse, truncatedRmse(pose, limit), 1e-4);
      EXPECT_LT(result.truncated_rmse, 0.97 * result.truncated_rmse_before);
      EXPECT_LT(result.truncated_rmse, limit);
    }
  // Without a limit all points have a match, and both are plain means.
  IcpOf<double> icp;
  align(icp, source, target, 200);
  EXPECT_EQ(icp.getResult().truncated_rmse_before, icp.getResult().rmse_before);
  EXPECT_EQ(icp.getResult().truncated_rmse, icp.getResult().rmse);
}

TEST_F(Numerics, ADoubleResultIsARotationToItsLastDigits)
{
  const auto error = [](const Eigen::Matrix4d& matrix) {
    const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
    return std::max((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(),
                    std::abs(rotation.determinant() - 1));
  };
  // As float holds it, so not a rotation.
  Eigen::Matrix4d guess = Eigen::Matrix4d::Identity();
  guess.topLeftCorner<3, 3>() =
      Eigen::AngleAxisf(0.02F, Eigen::Vector3f(3, 1, 2).normalized()).toRotationMatrix().cast<double>();
  EXPECT_GT(error(guess), 1e-9);
  for (const Way& way : ways)
    for (const int iterations : {1, 2, 40})
      for (const bool accelerated : {false, true}) {
        SCOPED_TRACE(std::string(way.name) + (accelerated ? ", accelerated" : "") + " " + std::to_string(iterations));
        IcpOf<double> icp;
        follow(way, icp);
        icp.setAndersonAcceleration(accelerated);
        icp.setInputSource(source);
        icp.setInputTarget(target);
        icp.setMaximumIterations(iterations);
        Cloud output;
        icp.align(output, guess);
        EXPECT_LT(error(icp.getFinalTransformation()), 1e-15);
        EXPECT_LT(error(icp.getLastIncrementalTransformation()), 1e-15);
      }
}

TEST_F(Numerics, OnlyRigidGuessesAreAccepted)
{
  using Change = std::function<void(Eigen::Matrix4f&)>;
  const std::pair<const char*, Change> changes[] = {{"scaled", [](auto& g) { g.template topLeftCorner<3, 3>() *= 2; }},
                                                    {"mirrored", [](auto& g) { g.col(2) *= -1; }},
                                                    {"sheared", [](auto& g) { g(0, 1) += 0.01F; }},
                                                    {"not a number", [](auto& g) { g(1, 1) = not_a_number; }},
                                                    {"nowhere", [](auto& g) { g(1, 3) = infinity; }},
                                                    {"projective", [](auto& g) { g(3, 0) = 0.1F; }},
                                                    {"zero", [](auto& g) { g.setZero(); }}};
  for (const CorrespondenceSearch search : searches)
    for (const auto& [name, change] : changes) {
      SCOPED_TRACE(name);
      Icp icp;
      icp.setCorrespondenceSearch(search);
      align(icp, source, target);
      Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
      change(guess);
      Cloud output;
      icp.align(output, guess);
      EXPECT_FALSE(icp.hasConverged());
      EXPECT_EQ(icp.getResult().reason, Reason::Error);
      EXPECT_NE(icp.getResult().message.find("not a rigid transform"), std::string::npos) << icp.getResult().message;
      guess = Eigen::Matrix4f::Identity();
      guess(0, 1) += 5e-4F;
      icp.align(output, guess);
      EXPECT_TRUE(icp.hasConverged());
    }
}

// PCL compares squares: the sign of a limit does not matter, and what is no number limits nothing.
TEST_F(Numerics, LimitsMeanWhatTheyMeanToStockPcl)
{
  const double limits[] = {0, -0.0, 1e-30, -1e-30, 0.05, -0.05, 1e30, -1e30, infinity, -infinity, not_a_number};
  (*source)[0] = (*target)[0]; // at 0 of one another
  for (const double limit : limits) {
    pcl::IterativeClosestPoint<PointXYZ, PointXYZ> stock;
    stock.setInputSource(source);
    stock.setInputTarget(target);
    stock.setMaxCorrespondenceDistance(limit);
    stock.setMaximumIterations(3);
    Cloud output;
    stock.align(output);
    std::vector<std::function<void(Icp&)>> configurations{
        [](Icp&) {},
        [](Icp& icp) { icp.setPipeline(Pipeline::Staged); },
        [](Icp& icp) { icp.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree); },
        [](Icp& icp) { icp.setSearchMethodTarget(pcl::make_shared<pcl::search::KdTree<PointXYZ>>()); }};
    for (std::size_t c = 0; c < configurations.size(); ++c) {
      SCOPED_TRACE(std::to_string(limit) + ", configuration " + std::to_string(c));
      Icp icp;
      configurations[c](icp);
      icp.setMaxCorrespondenceDistance(limit);
      align(icp, source, target, 3);
      EXPECT_EQ(icp.hasConverged(), stock.hasConverged());
      EXPECT_EQ(icp.getConvergeCriteria()->getConvergenceState(), stock.getConvergeCriteria()->getConvergenceState());
      EXPECT_LT((icp.getFinalTransformation() - stock.getFinalTransformation()).norm(), 1e-4);
    }
  }
}

TEST_F(Numerics, AFitnessScoreLeavesTheNextAsItIs)
{
  for (const CorrespondenceSearch search : searches) {
    Icp icp;
    icp.setCorrespondenceSearch(search);
    align(icp, source, target, 5);
    const double ranges[] = {-1, 0.1, -infinity, 1e-3, not_a_number, 0.5, 0, 1e-40, 0.1, 1e300};
    for (const double range : ranges) {
      SCOPED_TRACE(range);
      Icp fresh;
      fresh.setCorrespondenceSearch(search);
      align(fresh, source, target, 5);
      const double expected = fresh.getFitnessScore(range);
      EXPECT_EQ(icp.getFitnessScore(range), expected);
      EXPECT_TRUE(range > 0 || expected == std::numeric_limits<double>::max());
    }
  }
}
