#pragma once

#include "scenes.h"

#include <pcl_gpu_icp/icp.h>

#include <pcl/registration/icp.h>

#include <gtest/gtest.h>

/// What one align() left.
template <typename PointSource, typename Scalar>
struct Outcome {
  pcl::PointCloud<PointSource> output;
  Eigen::Matrix<Scalar, 4, 4> transformation;
  bool converged;
  int state;
  double fitness;
};

template <typename Icp, typename PointSource, typename PointTarget, typename Scalar, typename Configure>
Outcome<PointSource, Scalar> alignWith(Icp& icp,
                                       const pcl::shared_ptr<pcl::PointCloud<PointSource>>& source,
                                       const pcl::shared_ptr<pcl::PointCloud<PointTarget>>& target,
                                       Configure configure,
                                       const Eigen::Matrix<Scalar, 4, 4>& guess)
{
  icp.setInputSource(source);
  icp.setInputTarget(target);
  configure(icp);
  Outcome<PointSource, Scalar> outcome;
  icp.align(outcome.output, guess);
  outcome.transformation = icp.getFinalTransformation();
  outcome.converged = icp.hasConverged();
  outcome.state = icp.getConvergeCriteria()->getConvergenceState();
  outcome.fitness = icp.getFitnessScore();
  return outcome;
}

/// Aligns with a fresh pcl::IterativeClosestPoint and a fresh pcl_gpu_icp::IterativeClosestPoint, both set up by
/// configure(icp), and expects the same answer. The tolerances allow for a few matches that rounding decides: one of
/// 2500 that changes its partner 5 cm away moves the centroid by 2e-5 m.
/// \return our transformation
template <typename Scalar = float, typename PointSource, typename PointTarget, typename Configure>
Eigen::Matrix<Scalar, 4, 4>
expectSameAsStock(const pcl::shared_ptr<pcl::PointCloud<PointSource>>& source,
                  const pcl::shared_ptr<pcl::PointCloud<PointTarget>>& target,
                  Configure configure,
                  const Eigen::Matrix<Scalar, 4, 4>& guess = Eigen::Matrix<Scalar, 4, 4>::Identity(),
                  double metres = 5e-4,
                  double degrees = 0.02)
{
  pcl::IterativeClosestPoint<PointSource, PointTarget, Scalar> stock;
  const auto expected = alignWith(stock, source, target, configure, guess);
  Eigen::Matrix<Scalar, 4, 4> transformation;
  // With our own search last: a search method of the caller's excludes it.
  for (const auto search :
       {pcl_gpu_icp::CorrespondenceSearch::PclKdTree, pcl_gpu_icp::CorrespondenceSearch::DeviceKdTree}) {
    SCOPED_TRACE(pcl_gpu_icp::toString(search));
    pcl_gpu_icp::IterativeClosestPoint<PointSource, PointTarget, Scalar> ours;
    ours.setCorrespondenceSearch(search);
    const auto actual = alignWith(ours, source, target, configure, guess);
    if (ours.getResult().message.find("excludes a search method") != std::string::npos)
      break;
    transformation = actual.transformation;
    EXPECT_EQ(ours.getResult().message.empty(), ours.getResult().reason != pcl_gpu_icp::Reason::NoCorrespondences)
        << ours.getResult().message;
    EXPECT_EQ(actual.converged, expected.converged);
    EXPECT_EQ(actual.state, expected.state);
    EXPECT_LT(scenes::metresBetween<Scalar>(actual.transformation, expected.transformation), metres);
    EXPECT_LT(scenes::degreesBetween<Scalar>(actual.transformation, expected.transformation), degrees);
    EXPECT_NEAR(actual.fitness, expected.fitness, 5e-3 * expected.fitness + 1e-10);
    EXPECT_EQ(actual.output.width, expected.output.width);
    EXPECT_EQ(actual.output.height, expected.output.height);
    EXPECT_EQ(actual.output.size(), expected.output.size());
    double farthest = 0;
    for (std::size_t i = 0; i < std::min(actual.output.size(), expected.output.size()); ++i)
      farthest =
          std::max<double>(farthest, (actual.output[i].getVector3fMap() - expected.output[i].getVector3fMap()).norm());
    EXPECT_LT(farthest, 5 * metres);
  }
  return transformation;
}
