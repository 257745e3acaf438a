// Every feature of pcl::IterativeClosestPoint gives the same answer after the change of namespace.
#include "parity.h"

#include <pcl/registration/correspondence_estimation_normal_shooting.h>
#include <pcl/registration/correspondence_rejection_distance.h>
#include <pcl/registration/correspondence_rejection_median_distance.h>
#include <pcl/registration/correspondence_rejection_one_to_one.h>
#include <pcl/registration/correspondence_rejection_sample_consensus.h>
#include <pcl/registration/correspondence_rejection_trimmed.h>
#include <pcl/registration/transformation_estimation_lm.h>
#include <pcl/registration/transformation_estimation_svd_scale.h>

#include <atomic>

using pcl::PointXYZ;
using Cloud = pcl::PointCloud<PointXYZ>;

namespace {

const Cloud::Ptr target = scenes::hills<PointXYZ>(3000);
const Cloud::Ptr source = scenes::moved(*scenes::hills<PointXYZ>(2500, 2), scenes::smallMotion());

/// A feature that changes nothing would pass unnoticed: its result must differ from that of the plain settings.
void expectItMatters(const Eigen::Matrix4f& with_feature, int iterations)
{
  pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ> plain;
  const auto without = alignWith(
      plain,
      source,
      target,
      [&](auto& icp) { icp.setMaximumIterations(iterations); },
      Eigen::Matrix4f::Identity().eval());
  EXPECT_GT(scenes::metresBetween<float>(with_feature, without.transformation), 2e-3);
}

} // namespace

TEST(IcpParity, Defaults)
{
  expectSameAsStock(source, target, [](auto&) {});
}

TEST(IcpParity, ManyIterations)
{
  // With the 49th ours stands still and ends; the drift of stock's float cloud keeps it going until the 379th.
  expectSameAsStock(source, target, [](auto& icp) { icp.setMaximumIterations(45); });
}

TEST(IcpParity, ScalarDouble)
{
  expectSameAsStock<double>(source, target, [](auto& icp) { icp.setMaximumIterations(30); });
}

TEST(IcpParity, Guess)
{
  const Eigen::Affine3f far = Eigen::Translation3f(3, 2, -1) * Eigen::AngleAxisf(2.0F, Eigen::Vector3f::UnitZ());
  const auto far_source = scenes::moved(*source, far);
  expectSameAsStock(
      far_source, target, [](auto& icp) { icp.setMaximumIterations(30); }, far.inverse().matrix().eval());
}

TEST(IcpParity, MaxCorrespondenceDistance)
{
  const Eigen::Matrix4f result = expectSameAsStock(source, target, [](auto& icp) {
    icp.setMaximumIterations(20);
    icp.setMaxCorrespondenceDistance(0.06);
  });
  expectItMatters(result, 20);
}

TEST(IcpParity, ReciprocalCorrespondences)
{
  const Eigen::Matrix4f result = expectSameAsStock(source, target, [](auto& icp) {
    icp.setMaximumIterations(20);
    icp.setUseReciprocalCorrespondences(true);
  });
  expectItMatters(result, 20);
}

TEST(IcpParity, ReciprocalWithMaxDistance)
{
  expectSameAsStock(source, target, [](auto& icp) {
    icp.setMaximumIterations(15);
    icp.setMaxCorrespondenceDistance(0.1);
    icp.setUseReciprocalCorrespondences(true);
  });
}

TEST(IcpParity, TrimmedRejector)
{
  const Eigen::Matrix4f result = expectSameAsStock(source, target, [](auto& icp) {
    pcl::registration::CorrespondenceRejectorTrimmed::Ptr rejector(
        new pcl::registration::CorrespondenceRejectorTrimmed);
    rejector->setOverlapRatio(0.7F);
    icp.addCorrespondenceRejector(rejector);
    icp.setMaximumIterations(20);
  });
  expectItMatters(result, 20);
}

TEST(IcpParity, ChainOfRejectors)
{
  const Eigen::Matrix4f result = expectSameAsStock(source, target, [](auto& icp) {
    pcl::registration::CorrespondenceRejectorMedianDistance::Ptr median(
        new pcl::registration::CorrespondenceRejectorMedianDistance);
    median->setMedianFactor(2.0);
    icp.addCorrespondenceRejector(median);
    icp.addCorrespondenceRejector(
        pcl::registration::CorrespondenceRejectorOneToOne::Ptr(new pcl::registration::CorrespondenceRejectorOneToOne));
    icp.setMaximumIterations(15);
  });
  expectItMatters(result, 15);
}

TEST(IcpParity, RejectorThatLooksAtThePoints)
{
  const Eigen::Matrix4f result = expectSameAsStock(source, target, [](auto& icp) {
    pcl::registration::CorrespondenceRejectorDistance::Ptr rejector(
        new pcl::registration::CorrespondenceRejectorDistance);
    rejector->setMaximumDistance(0.05F);
    icp.addCorrespondenceRejector(rejector);
    icp.setMaximumIterations(15);
  });
  expectItMatters(result, 15);
}

TEST(IcpParity, CallersEstimator)
{
  expectSameAsStock(
      source,
      target,
      [](auto& icp) {
        using Estimator = pcl::registration::TransformationEstimationLM<PointXYZ, PointXYZ>;
        icp.setTransformationEstimation(Estimator::Ptr(new Estimator));
        icp.setMaximumIterations(8);
      },
      Eigen::Matrix4f::Identity().eval(),
      1e-3,
      5e-2);
}

TEST(IcpParity, CallersEstimatorThatScales)
{
  Cloud::Ptr large(new Cloud(*source));
  for (auto& point : *large)
    point.getVector3fMap() *= 1.05F;
  pcl::IterativeClosestPoint<PointXYZ, PointXYZ> stock;
  pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ> ours;
  const auto configure = [](auto& icp) {
    using Estimator = pcl::registration::TransformationEstimationSVDScale<PointXYZ, PointXYZ>;
    icp.setTransformationEstimation(Estimator::Ptr(new Estimator));
    icp.setMaximumIterations(15);
  };
  const Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
  const auto expected = alignWith(stock, large, target, configure, guess);
  const auto actual = alignWith(ours, large, target, configure, guess);
  EXPECT_LT((actual.transformation - expected.transformation).norm(), 1e-3);
}

TEST(IcpParity, CallersSearchMethodIsAsked)
{
  struct CountingTree : pcl::search::KdTree<PointXYZ> {
    int
    nearestKSearch(const PointXYZ& point, int k, pcl::Indices& indices, std::vector<float>& distances) const override
    {
      ++queries;
      return pcl::search::KdTree<PointXYZ>::nearestKSearch(point, k, indices, distances);
    }
    using pcl::search::KdTree<PointXYZ>::nearestKSearch;
    mutable std::atomic<int> queries{0};
  };
  std::vector<pcl::shared_ptr<CountingTree>> trees;
  expectSameAsStock(source, target, [&](auto& icp) {
    trees.push_back(pcl::make_shared<CountingTree>());
    icp.setSearchMethodTarget(trees.back());
    icp.setMaximumIterations(5);
  });
  // Stock PCL's; ours, five iterations and the fitness score; that of the alignment that refuses it.
  ASSERT_EQ(trees.size(), 3U);
  EXPECT_EQ(trees[1]->queries, int(6 * source->size()));
}

TEST(IcpParity, CachedSearchMethods)
{
  for (const bool cached : {false, true})
    for (const bool reciprocal : {false, true})
      expectSameAsStock(source, target, [&](auto& icp) {
        pcl::search::KdTree<PointXYZ>::Ptr tree(new pcl::search::KdTree<PointXYZ>);
        if (cached)
          tree->setInputCloud(target);
        icp.setSearchMethodTarget(tree, cached);
        icp.setUseReciprocalCorrespondences(reciprocal);
        icp.setMaximumIterations(5);
      });
}

TEST(IcpParity, CallersReciprocalSearchMethod)
{
  expectSameAsStock(source, target, [](auto& icp) {
    icp.setSearchMethodSource(pcl::search::KdTree<PointXYZ>::Ptr(new pcl::search::KdTree<PointXYZ>));
    icp.setUseReciprocalCorrespondences(true);
    icp.setMaximumIterations(5);
  });
}

TEST(IcpParity, CallersPointRepresentation)
{
  // Heights count ten times.
  struct Tall : pcl::PointRepresentation<PointXYZ> {
    Tall() { nr_dimensions_ = 3; }
    void copyToFloatArray(const PointXYZ& point, float* out) const override
    {
      out[0] = point.x;
      out[1] = point.y;
      out[2] = 10 * point.z;
    }
  };
  const Eigen::Matrix4f result = expectSameAsStock(source, target, [](auto& icp) {
    icp.setPointRepresentation(pcl::make_shared<const Tall>());
    icp.setMaximumIterations(10);
  });
  expectItMatters(result, 10);
}

TEST(IcpParity, EveryConvergenceCriterion)
{
  // A threshold may be met an iteration earlier or later: the steps are below 2 mm by then.
  const auto criterion = [&](auto set) {
    expectSameAsStock(
        source,
        target,
        [&](auto& icp) {
          icp.setMaximumIterations(200);
          set(icp);
        },
        Eigen::Matrix4f::Identity().eval(),
        4e-3,
        0.2);
  };
  criterion([](auto& icp) { icp.setMaximumIterations(7); });
  criterion([](auto& icp) { icp.setTransformationEpsilon(1e-7); });
  criterion([](auto& icp) {
    icp.setTransformationEpsilon(1e-6);
    icp.setTransformationRotationEpsilon(0.999999);
  });
  criterion([](auto& icp) { icp.setEuclideanFitnessEpsilon(1e-3); });
  criterion([](auto& icp) { icp.getConvergeCriteria()->setAbsoluteMSE(1e-5); });
  criterion([](auto& icp) {
    icp.setTransformationEpsilon(1e-6);
    icp.getConvergeCriteria()->setMaximumIterationsSimilarTransforms(3);
  });
  criterion([](auto& icp) {
    icp.setMaximumIterations(5);
    icp.getConvergeCriteria()->setFailureAfterMaximumIterations(true);
  });
}

TEST(IcpParity, TooFewCorrespondences)
{
  expectSameAsStock(source, scenes::moved(*target, Eigen::Affine3f(Eigen::Translation3f(0, 0, 100))), [](auto& icp) {
    icp.setMaxCorrespondenceDistance(0.5);
  });
}

TEST(IcpParity, VisualiserCallback)
{
  std::vector<std::size_t> pairs;
  std::vector<float> last_x;
  std::function<void(const Cloud&, const pcl::Indices&, const Cloud&, const pcl::Indices&)> callback =
      [&](const Cloud& cloud, const pcl::Indices& source_indices, const Cloud&, const pcl::Indices& target_indices) {
        EXPECT_EQ(source_indices.size(), target_indices.size());
        pairs.push_back(source_indices.size());
        last_x.push_back(cloud[0].x);
      };
  expectSameAsStock(source, target, [&](auto& icp) {
    icp.registerVisualizationCallback(callback);
    icp.setMaximumIterations(6);
  });
  // Once at registration and once an iteration, for stock PCL and for ours with either search.
  ASSERT_EQ(pairs.size(), 21U);
  for (int i = 7; i < 21; ++i) {
    EXPECT_EQ(pairs[i], pairs[i % 7]);
    EXPECT_NEAR(last_x[i], last_x[i % 7], 5e-4);
  }
}

TEST(IcpParity, FitnessScoreWithRange)
{
  pcl::IterativeClosestPoint<PointXYZ, PointXYZ> stock;
  pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ> ours;
  const auto configure = [](auto& icp) { icp.setMaximumIterations(3); };
  const Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
  alignWith(stock, source, target, configure, guess);
  alignWith(ours, source, target, configure, guess);
  for (const double range : {1e-5, 1e-4, 1e-3, 1.0}) {
    const double expected = stock.getFitnessScore(range);
    EXPECT_NEAR(ours.getFitnessScore(range), expected, 1e-2 * expected) << range;
  }
  EXPECT_EQ(ours.getFitnessScore(-1.0), std::numeric_limits<double>::max());
  EXPECT_EQ(ours.getFitnessScore({1, 2}, {3, 5}), stock.getFitnessScore({1, 2}, {3, 5}));
}

TEST(IcpParity, LastIncrement)
{
  pcl::IterativeClosestPoint<PointXYZ, PointXYZ> stock;
  pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ> ours;
  const auto configure = [](auto& icp) { icp.setMaximumIterations(4); };
  const Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
  alignWith(stock, source, target, configure, guess);
  alignWith(ours, source, target, configure, guess);
  EXPECT_LT((ours.getLastIncrementalTransformation() - stock.getLastIncrementalTransformation()).norm(), 1e-4);
}

TEST(IcpParity, ThroughTheBaseClass)
{
  using Icp = pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ>;
  const pcl::Registration<PointXYZ, PointXYZ>::Ptr registration(new Icp);
  registration->setInputSource(source);
  registration->setInputTarget(target);
  registration->setMaximumIterations(20);
  Cloud output;
  registration->align(output);
  pcl::IterativeClosestPoint<PointXYZ, PointXYZ> stock;
  const auto expected = alignWith(
      stock, source, target, [](auto& icp) { icp.setMaximumIterations(20); }, Eigen::Matrix4f::Identity().eval());
  EXPECT_TRUE(registration->hasConverged());
  EXPECT_LT((registration->getFinalTransformation() - expected.transformation).norm(), 1e-3);
  EXPECT_NEAR(registration->getFitnessScore(), expected.fitness, 5e-3 * expected.fitness);
}
