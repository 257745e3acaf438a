// Point-to-plane: the estimator against PCL's own, and ICP with it, by whichever path the increment comes, against
// stock PCL's ICP with PCL's estimator.
#include "parity.h"

#include <pcl_gpu_icp/transformation_estimation_point_to_plane_lls.h>

#include <pcl/registration/correspondence_rejection_trimmed.h>
#include <pcl/registration/transformation_estimation_point_to_plane_lls.h>

using pcl::PointNormal;
using pcl::PointXYZ;
using pcl_gpu_icp::CorrespondenceSearch;
using pcl_gpu_icp::Degeneracy;
using pcl_gpu_icp::Metric;
using pcl_gpu_icp::Pipeline;
using pcl_gpu_icp::Reason;

namespace {

const float not_a_number = std::numeric_limits<float>::quiet_NaN();
const Eigen::Matrix4f identity = Eigen::Matrix4f::Identity();
const auto eight_iterations = [](auto& icp) { icp.setMaximumIterations(8); };

/// scenes::hills() with the surface's own normals.
pcl::PointCloud<PointNormal>::Ptr hillsWithNormals(std::size_t points, unsigned seed)
{
  const auto cloud = scenes::hills<PointNormal>(points, seed);
  for (auto& point : *cloud) {
    const float slope_x = 0.68F * std::cos(1.7F * point.x) * std::cos(1.3F * point.y) + 0.2F * point.y;
    const float slope_y = -0.52F * std::sin(1.7F * point.x) * std::sin(1.3F * point.y) + 0.2F * point.x;
    point.getNormalVector3fMap() = Eigen::Vector3f(-slope_x, -slope_y, 1).normalized();
  }
  return cloud;
}

template <typename PointT, typename Scalar = float>
auto planes()
{
  using Estimation = pcl_gpu_icp::TransformationEstimationPointToPlaneLLS<PointT, PointT, Scalar>;
  return typename Estimation::Ptr(new Estimation);
}

template <typename Scalar>
using StockPlanes = pcl::registration::TransformationEstimationPointToPlaneLLS<PointNormal, PointNormal, Scalar>;

class PointToPlane : public testing::Test {
protected:
  pcl::PointCloud<PointNormal>::Ptr target = hillsWithNormals(3000, 1);
  pcl::PointCloud<PointNormal>::Ptr source = scenes::moved(*hillsWithNormals(2500, 2), scenes::smallMotion());
  const Eigen::Matrix4f truth = scenes::smallMotion().inverse().matrix();
};

} // namespace

TEST_F(PointToPlane, EstimatesWhatPclEstimates)
{
  const StockPlanes<float> stock;
  const auto ours = planes<PointNormal>();
  // About its centroid the source turns by little.
  const auto moved = scenes::moved(*target,
                                   Eigen::Affine3f(Eigen::Translation3f(0.01F, -0.02F, 0.015F) *
                                                   Eigen::AngleAxisf(2e-3F, Eigen::Vector3f::UnitY())));
  (*moved)[3].x = (*moved)[5].normal_x = (*target)[7].normal_y = (*target)[9].z = not_a_number;
  pcl::Indices every_third, some;
  pcl::Correspondences correspondences;
  pcl::PointCloud<PointNormal> thirds, sources;
  for (int i = 0; i < int(target->size()); i += 3) {
    every_third.push_back(i);
    thirds.push_back((*target)[i]);
    sources.push_back((*moved)[i]);
    correspondences.push_back({i, i, 0});
  }
  Eigen::Matrix4f expected, actual;
  const auto expectSame = [&](std::size_t pairs) {
    EXPECT_LT(scenes::metresBetween<float>(actual, expected), 2e-5);
    EXPECT_LT(scenes::degreesBetween<float>(actual, expected), 1e-3);
    EXPECT_GT(scenes::metresBetween<float>(actual, identity), 1e-2);
    EXPECT_EQ(ours->getEstimate().pairs, pairs);
    EXPECT_EQ(ours->getEstimate().degeneracy, Degeneracy::None);
  };
  stock.estimateRigidTransformation(*moved, *target, expected);
  ours->estimateRigidTransformation(*moved, *target, actual);
  expectSame(target->size() - 3);
  stock.estimateRigidTransformation(*moved, every_third, thirds, expected);
  ours->estimateRigidTransformation(*moved, every_third, thirds, actual);
  expectSame(thirds.size() - 2);
  stock.estimateRigidTransformation(*moved, every_third, *target, every_third, expected);
  ours->estimateRigidTransformation(*moved, every_third, *target, every_third, actual);
  expectSame(thirds.size() - 2);
  stock.estimateRigidTransformation(*moved, *target, correspondences, expected);
  ours->estimateRigidTransformation(*moved, *target, correspondences, actual);
  expectSame(thirds.size() - 2);

  const Eigen::Matrix4f before = actual;
  ours->estimateRigidTransformation(*moved, thirds, actual);
  EXPECT_EQ(actual, before) << "sizes that differ";
}

TEST_F(PointToPlane, EstimatorsCanBeCopiedAndAssigned)
{
  const auto run = [&](const auto& estimator) {
    Eigen::Matrix4f matrix;
    estimator.estimateRigidTransformation(*target, *scenes::moved(*target, scenes::smallMotion()), matrix);
    return matrix;
  };
  auto original = *planes<PointNormal>();
  original.setNumberOfNeighbours(7);
  const Eigen::Matrix4f expected = run(original);
  const auto copy = original;
  EXPECT_EQ(copy.getNumberOfNeighbours(), 7U);
  EXPECT_EQ(run(copy), expected);
  auto assigned = *planes<PointNormal>();
  assigned = original;
  EXPECT_EQ(assigned.getNumberOfNeighbours(), 7U);
  EXPECT_EQ(run(assigned), expected);
}

TEST_F(PointToPlane, IcpIsThatOfStockPcl)
{
  const auto compare = [this](auto scalar, auto configure, double metres) {
    using Scalar = decltype(scalar);
    const Eigen::Matrix<Scalar, 4, 4> guess = Eigen::Matrix<Scalar, 4, 4>::Identity();
    pcl::IterativeClosestPoint<PointNormal, PointNormal, Scalar> stock;
    stock.setTransformationEstimation(typename StockPlanes<Scalar>::Ptr(new StockPlanes<Scalar>));
    const auto expected = alignWith(stock, source, target, configure, guess);
    for (const auto search : {CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree}) {
      SCOPED_TRACE(toString(search));
      pcl_gpu_icp::IterativeClosestPoint<PointNormal, PointNormal, Scalar> ours;
      ours.setCorrespondenceSearch(search);
      ours.setTransformationEstimation(planes<PointNormal, Scalar>());
      const auto actual = alignWith(ours, source, target, configure, guess);
      EXPECT_EQ(actual.converged, expected.converged);
      EXPECT_LT(scenes::metresBetween<Scalar>(actual.transformation, expected.transformation), metres);
      EXPECT_LT(scenes::degreesBetween<Scalar>(actual.transformation, expected.transformation), 50 * metres);
      EXPECT_NEAR(actual.fitness, expected.fitness, 1e-3 * expected.fitness);
      EXPECT_EQ(ours.getResult().metric, Metric::Plane);
      EXPECT_EQ(ours.getResult().degeneracy, Degeneracy::None);
      EXPECT_EQ(ours.getResult().device_times.count("plane_sums"), 1U) << "the matching pass estimates";
      ASSERT_LT((actual.output[7].getNormalVector3fMap() - expected.output[7].getNormalVector3fMap()).norm(), 1e-3);
    }
  };
  compare(0.0F, eight_iterations, 1e-4);
  compare(0.0, eight_iterations, 1e-4);
  compare(
      0.0F,
      [](auto& icp) {
        icp.setMaximumIterations(12);
        icp.setMaxCorrespondenceDistance(0.1);
      },
      2e-4);
}

TEST_F(PointToPlane, EveryPathOfTheIncrementLeadsToOneAnswer)
{
  const auto aligned = [&](auto configure) {
    pcl_gpu_icp::IterativeClosestPoint<PointNormal, PointNormal> icp;
    icp.setTransformationEstimation(planes<PointNormal>());
    const auto outcome = alignWith(
        icp,
        source,
        target,
        [&](auto& aligner) {
          aligner.setMaximumIterations(12);
          configure(aligner);
        },
        identity);
    EXPECT_EQ(icp.getResult().message, "");
    EXPECT_EQ(icp.getResult().metric, Metric::Plane);
    EXPECT_FALSE(icp.getResult().device.name.empty());
    return outcome.transformation;
  };
  const auto fused = aligned([](auto&) {});
  const auto expectSame = [&](const char* what, auto configure) {
    const auto other = aligned(configure);
    EXPECT_LT(scenes::metresBetween<float>(other, fused), 2e-5) << what;
    EXPECT_LT(scenes::degreesBetween<float>(other, fused), 1e-3) << what;
  };
  expectSame("staged", [](auto& icp) { icp.setPipeline(Pipeline::Staged); });
  expectSame("a rejector", [](auto& icp) {
    const auto all = pcl::make_shared<pcl::registration::CorrespondenceRejectorTrimmed>();
    all->setOverlapRatio(1);
    icp.addCorrespondenceRejector(all);
  });
  expectSame("a search method",
             [](auto& icp) { icp.setSearchMethodTarget(pcl::make_shared<pcl::search::KdTree<PointNormal>>()); });
  int shown = 0;
  std::function<pcl::Registration<PointNormal, PointNormal>::UpdateVisualizerCallbackSignature> show =
      [&](const auto&, const auto&, const auto&, const auto&) { ++shown; };
  expectSame("a visualiser", [&](auto& icp) { icp.registerVisualizationCallback(show); });
  EXPECT_GT(shown, 0);
  const auto mutual = aligned([](auto& icp) { icp.setUseReciprocalCorrespondences(true); });
  EXPECT_LT(scenes::metresBetween<float>(mutual, truth), 5e-3);
}

TEST_F(PointToPlane, NormalsAreEstimatedWhereThePointsHaveNone)
{
  const auto bare_target = scenes::hills<PointXYZ>(6000, 1);
  const auto bare_source = scenes::moved(*scenes::hills<PointXYZ>(2500, 2), scenes::smallMotion());
  for (const auto search : {CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree}) {
    SCOPED_TRACE(toString(search));
    pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ> points, to_planes;
    points.setCorrespondenceSearch(search);
    to_planes.setCorrespondenceSearch(search);
    const auto estimation = planes<PointXYZ>();
    to_planes.setTransformationEstimation(estimation);
    const auto toTheEnd = [](auto& icp) {
      icp.setMaximumIterations(500);
      icp.setTransformationEpsilon(1e-8);
    };
    alignWith(points, bare_source, bare_target, toTheEnd, identity);
    const auto outcome = alignWith(to_planes, bare_source, bare_target, toTheEnd, identity);
    EXPECT_EQ(to_planes.getResult().reason, Reason::Transform);
    EXPECT_LT(4 * to_planes.getResult().iterations, points.getResult().iterations);
    EXPECT_LT(scenes::metresBetween<float>(outcome.transformation, truth), 3e-3);
    EXPECT_LT(scenes::degreesBetween<float>(outcome.transformation, truth), 0.1);

    // From fewer points other normals, so another answer.
    estimation->setNumberOfNeighbours(6);
    EXPECT_EQ(estimation->getNumberOfNeighbours(), 6U);
    const auto rougher = alignWith(to_planes, bare_source, bare_target, toTheEnd, identity);
    EXPECT_NE(rougher.transformation, outcome.transformation);
    estimation->setNumberOfNeighbours(2);
    alignWith(to_planes, bare_source, bare_target, toTheEnd, identity);
    EXPECT_EQ(to_planes.getResult().reason, Reason::Error);
    EXPECT_NE(to_planes.getResult().message.find("from 3 to 32 points, not from 2"), std::string::npos);
  }
}

TEST_F(PointToPlane, TheMetricAndTheNormalsMayChange)
{
  pcl_gpu_icp::IterativeClosestPoint<PointNormal, PointNormal> icp, never_otherwise;
  const auto by_points = alignWith(never_otherwise, source, target, eight_iterations, identity).transformation;
  const auto point_estimation = never_otherwise.getResult();
  EXPECT_EQ(point_estimation.metric, Metric::Point);
  EXPECT_EQ(point_estimation.device_times.count("plane_sums"), 0U);

  const auto default_estimation =
      pcl::make_shared<pcl_gpu_icp::TransformationEstimationSVD<PointNormal, PointNormal>>();
  icp.setTransformationEstimation(planes<PointNormal>());
  const auto by_planes = alignWith(icp, source, target, eight_iterations, identity).transformation;
  icp.setTransformationEstimation(default_estimation);
  EXPECT_LT((alignWith(icp, source, target, eight_iterations, identity).transformation - by_points).norm(), 1e-6);
  icp.setTransformationEstimation(planes<PointNormal>());
  EXPECT_EQ(alignWith(icp, source, target, eight_iterations, identity).transformation, by_planes) << "to the bit";

  // In place, without a word to the aligner.
  for (auto& point : *target)
    point.getNormalVector3fMap() = Eigen::Vector3f::UnitZ();
  const auto flat = alignWith(icp, source, target, eight_iterations, identity).transformation;
  EXPECT_GT((flat - by_planes).norm(), 1e-3);
  EXPECT_EQ(icp.getResult().degeneracy, Degeneracy::Sliding);
  EXPECT_EQ(icp.getResult().free_motions, 3);
}

TEST_F(PointToPlane, AFloorLeavesThreeMotionsAsTheyWere)
{
  std::mt19937 generator(1);
  std::uniform_real_distribution<float> within(-2, 2);
  for (const bool listed : {false, true}) {
    const pcl::PointCloud<PointXYZ>::Ptr floor(new pcl::PointCloud<PointXYZ>);
    for (int i = 0; i < 2000; ++i)
      floor->push_back(PointXYZ(within(generator), within(generator), 0));
    const Eigen::Affine3f tilt = Eigen::Translation3f(0, 0, 0.1F) * Eigen::AngleAxisf(0.02F, Eigen::Vector3f::UnitX());
    pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ> icp;
    icp.setTransformationEstimation(planes<PointXYZ>());
    icp.setPipeline(listed ? Pipeline::Staged : Pipeline::Fused);
    const auto outcome = alignWith(icp, scenes::moved(*floor, tilt), floor, eight_iterations, identity);
    EXPECT_EQ(icp.getResult().degeneracy, Degeneracy::Sliding);
    EXPECT_EQ(icp.getResult().free_motions, 3);
    for (const auto& point : outcome.output)
      ASSERT_LT(std::abs(point.z), 1e-5);
    EXPECT_LT(scenes::metresBetween<float>(outcome.transformation, tilt.inverse().matrix()), 1e-3);
    EXPECT_LT(scenes::degreesBetween<float>(outcome.transformation, tilt.inverse().matrix()), 0.05);
  }
}

TEST_F(PointToPlane, WithoutNormalsThereIsNoAnswer)
{
  for (auto& point : *target)
    point.getNormalVector3fMap() = Eigen::Vector3f::Constant(not_a_number);
  pcl_gpu_icp::IterativeClosestPoint<PointNormal, PointNormal> icp;
  icp.setTransformationEstimation(planes<PointNormal>());
  const auto outcome = alignWith(icp, source, target, eight_iterations, identity);
  EXPECT_EQ(outcome.transformation, identity);
  EXPECT_FALSE(icp.hasConverged());
  EXPECT_EQ(icp.getResult().reason, Reason::Error);
}

TEST_F(PointToPlane, AndersonAccelerationKeepsTheEnd)
{
  const auto toTheEnd = [](auto& icp) {
    icp.setMaximumIterations(200);
    icp.setTransformationEpsilon(1e-12);
  };
  pcl_gpu_icp::IterativeClosestPoint<PointNormal, PointNormal> plain, accelerated;
  plain.setTransformationEstimation(planes<PointNormal>());
  accelerated.setTransformationEstimation(planes<PointNormal>());
  accelerated.setAndersonAcceleration(true);
  const auto expected = alignWith(plain, source, target, toTheEnd, identity);
  const auto actual = alignWith(accelerated, source, target, toTheEnd, identity);
  EXPECT_LE(accelerated.getResult().iterations, plain.getResult().iterations + 5);
  EXPECT_LT(scenes::metresBetween<float>(actual.transformation, expected.transformation), 2e-3);
}
