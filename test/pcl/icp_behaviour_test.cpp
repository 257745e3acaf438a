// Where PCL's own class departs from its documentation, this one keeps to it; and what getResult() says.
#include "icp_on_hills.h"

#include <pcl/registration/correspondence_rejection_trimmed.h>

#include <thread>

using pcl_gpu_icp::CorrespondenceSearch;
using pcl_gpu_icp::Degeneracy;
using pcl_gpu_icp::Pipeline;
using pcl_gpu_icp::Reason;

using IcpBehaviour = IcpOnHills;

TEST_F(IcpBehaviour, NonFinitePointsNeverTakePart)
{
  const auto clean = alignWith(icp, source, target, twenty_iterations, identity);
  Cloud::Ptr dirty_source(new Cloud(*source)), dirty_target(new Cloud(*target));
  for (int i = 0; i < 300; ++i) {
    dirty_source->push_back(PointXYZ(not_a_number, 0, 0));
    dirty_source->push_back(PointXYZ(0, std::numeric_limits<float>::infinity(), 0));
    dirty_target->push_back(PointXYZ(0, 0, not_a_number));
  }
  // is_dense says otherwise.
  dirty_source->is_dense = dirty_target->is_dense = true;
  Icp other;
  const auto dirty = alignWith(other, dirty_source, dirty_target, twenty_iterations, identity);
  EXPECT_LT((dirty.transformation - clean.transformation).norm(), 1e-6);
  EXPECT_NEAR(dirty.fitness, clean.fitness, 1e-5 * clean.fitness);
  EXPECT_EQ(other.getResult().source_points, source->size());
  EXPECT_EQ(other.getResult().source_dropped, 600U);
  EXPECT_EQ(other.getResult().target_dropped, 300U);
  EXPECT_TRUE(std::isnan(dirty.output[source->size()].x));
}

TEST_F(IcpBehaviour, NonFinitePointsWithTheCallersSearchMethod)
{
  const auto clean = alignWith(icp, source, target, twenty_iterations, identity);
  Cloud::Ptr dirty(new Cloud(*source));
  dirty->push_back(PointXYZ(not_a_number, not_a_number, not_a_number));
  for (const bool reciprocal : {false, true}) {
    Icp other;
    const auto outcome = alignWith(
        other,
        dirty,
        target,
        [&](auto& icp) {
          icp.setSearchMethodTarget(pcl::search::KdTree<PointXYZ>::Ptr(new pcl::search::KdTree<PointXYZ>));
          icp.setUseReciprocalCorrespondences(reciprocal);
          icp.setMaximumIterations(20);
        },
        identity);
    EXPECT_TRUE(outcome.converged);
    EXPECT_LT((outcome.transformation - clean.transformation).norm(), reciprocal ? 0.05 : 1e-5);
  }
}

TEST_F(IcpBehaviour, IndicesAreHonoured)
{
  pcl::IndicesPtr indices(new pcl::Indices);
  Cloud::Ptr subset(new Cloud);
  for (int i = 0; i < int(source->size()); i += 3) {
    indices->push_back(i);
    subset->push_back((*source)[i]);
  }
  Icp other;
  const auto expected = alignWith(other, subset, target, twenty_iterations, identity);
  const auto actual = alignWith(
      icp,
      source,
      target,
      [&](auto& aligner) {
        aligner.setIndices(indices);
        aligner.setMaximumIterations(20);
      },
      identity);
  EXPECT_EQ(actual.output.size(), subset->size());
  EXPECT_LT((actual.transformation - expected.transformation).norm(), 1e-6);
  EXPECT_NEAR(actual.fitness, expected.fitness, 1e-6 * expected.fitness);
  EXPECT_EQ(icp.getResult().inliers, subset->size());
  ASSERT_LT((actual.output[5].getVector3fMap() - expected.output[5].getVector3fMap()).norm(), 1e-6);
}

TEST_F(IcpBehaviour, CoincidentTargetPointsCountOnce)
{
  const auto clean = alignWith(icp, source, target, twenty_iterations, identity);
  for (int i = 0; i < 2000; ++i)
    target->push_back((*target)[7]);
  Icp other;
  const auto repeated = alignWith(other, source, target, twenty_iterations, identity);
  EXPECT_LT((repeated.transformation - clean.transformation).norm(), 1e-6);
  EXPECT_EQ(other.getResult().target_points, 3000U);
}

TEST_F(IcpBehaviour, RepeatedAlignGivesTheSameBits)
{
  const auto configure = [](auto& aligner) {
    aligner.setMaximumIterations(100);
    aligner.setEuclideanFitnessEpsilon(1e-4);
  };
  const auto first = alignWith(icp, source, target, configure, identity);
  const int iterations = icp.getResult().iterations;
  for (int i = 0; i < 3; ++i) {
    Cloud output;
    icp.align(output);
    EXPECT_EQ(icp.getFinalTransformation(), first.transformation);
    EXPECT_EQ(icp.getResult().iterations, iterations);
  }
  Icp single;
  single.setNumberOfThreads(1);
  EXPECT_EQ(alignWith(single, source, target, configure, identity).transformation, first.transformation);
}

TEST_F(IcpBehaviour, TargetTreeIsKeptUntilTheTargetChanges)
{
  const auto first = alignWith(icp, source, target, twenty_iterations, identity);
  const auto tree =
      std::dynamic_pointer_cast<pcl_gpu_icp::search::NearestKdTree<PointXYZ>>(icp.getSearchMethodTarget());
  ASSERT_TRUE(tree);
  const auto revision = tree->revision();
  Cloud output;
  icp.align(output);
  icp.setInputTarget(target);
  icp.align(output);
  EXPECT_EQ(tree->revision(), revision);

  // Changed in place, without a word to the aligner.
  const Eigen::Vector3f shift(0.02F, 0.01F, 0.03F);
  for (auto& point : *target)
    point.getVector3fMap() += shift;
  icp.align(output);
  EXPECT_EQ(tree->revision(), revision + 1);
  const Eigen::Vector3f moved_by = (icp.getFinalTransformation() - first.transformation).topRightCorner<3, 1>();
  EXPECT_LT((moved_by - shift).norm(), 0.01);
}

TEST_F(IcpBehaviour, TheDevicesTreeIsKeptUntilTheTargetChanges)
{
  icp.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree);
  const auto first = alignWith(icp, source, target, twenty_iterations, identity);
  const auto uploads = [&] { return icp.getResult().device_times.at("upload").count; };
  const unsigned with_tree = uploads();
  Cloud output;
  icp.setInputTarget(target);
  icp.align(output);
  EXPECT_EQ(icp.getFinalTransformation(), first.transformation);
  EXPECT_LT(uploads(), with_tree) << "the tree is there";

  const Eigen::Vector3f shift(0.02F, 0.01F, 0.03F);
  for (auto& point : *target)
    point.getVector3fMap() += shift;
  icp.align(output);
  EXPECT_EQ(uploads(), with_tree);
  const Eigen::Vector3f moved_by = (icp.getFinalTransformation() - first.transformation).topRightCorner<3, 1>();
  EXPECT_LT((moved_by - shift).norm(), 0.01);
}

TEST_F(IcpBehaviour, TheDevicesTreeExcludesTheCallersSearch)
{
  icp.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree);
  icp.setSearchMethodTarget(pcl::make_shared<pcl::search::KdTree<PointXYZ>>());
  alignWith(icp, source, target, twenty_iterations, identity);
  EXPECT_FALSE(icp.hasConverged());
  EXPECT_EQ(icp.getResult().reason, Reason::Error);
  EXPECT_NE(icp.getResult().message.find("excludes a search method"), std::string::npos);
}

TEST_F(IcpBehaviour, FewerAndFewerPointsAreSearchedForWithTheSameBits)
{
  for (const auto search : {CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree}) {
    SCOPED_TRACE(toString(search));
    Icp other;
    other.setCorrespondenceSearch(search);
    std::vector<std::size_t> shown;
    other.setIterationCallback([&](int, double, std::size_t searched) { shown.push_back(searched); });
    alignWith(
        other,
        source,
        target,
        [](auto& aligner) {
          aligner.setMaximumIterations(60);
          aligner.setTransformationEpsilon(1e-12);
        },
        identity);
    const auto& searched = other.getResult().searched;
    ASSERT_EQ(searched.size(), std::size_t(other.getResult().iterations));
    EXPECT_EQ(searched, shown);
    EXPECT_EQ(searched.front(), source->size());
    EXPECT_LT(searched.back(), source->size() / 10);
  }
}

TEST_F(IcpBehaviour, FitnessFollowsTheCloudsAsTheyAreNow)
{
  for (const auto search : {CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree}) {
    SCOPED_TRACE(toString(search));
    Icp other;
    other.setCorrespondenceSearch(search);
    const Cloud::Ptr changing(new Cloud(*source));
    const auto outcome = alignWith(other, changing, target, twenty_iterations, identity);
    // PCL's own way, through a search of every point.
    pcl::Registration<PointXYZ, PointXYZ>& as_pcl_has_it = other;
    EXPECT_NEAR(outcome.fitness, as_pcl_has_it.getFitnessScore(), 1e-5 * outcome.fitness);
    EXPECT_NEAR(other.getFitnessScore(1e-3), as_pcl_has_it.getFitnessScore(1e-3), 1e-5 * outcome.fitness);
    EXPECT_EQ(other.getFitnessScore(0), std::numeric_limits<double>::max());
    EXPECT_EQ(other.getFitnessScore(), outcome.fitness);
    for (auto& point : *changing)
      point.z += 0.5F;
    EXPECT_NEAR(other.getFitnessScore(), as_pcl_has_it.getFitnessScore(), 1e-5);
    EXPECT_GT(other.getFitnessScore(), 2 * outcome.fitness);
  }
}

TEST_F(IcpBehaviour, DegenerateClouds)
{
  const auto line = [](int points) {
    Cloud::Ptr cloud(new Cloud);
    for (int i = 0; i < points; ++i)
      cloud->push_back(PointXYZ(0.1F * i, 0.2F * i, -0.1F * i));
    return cloud;
  };
  const auto along_a_line = alignWith(
      icp, line(40), line(60), [](auto&) {}, identity);
  EXPECT_EQ(icp.getResult().degeneracy, Degeneracy::Line);
  EXPECT_TRUE(along_a_line.transformation.allFinite());
  EXPECT_LT((along_a_line.transformation - identity).norm(), 1e-5);

  Cloud::Ptr one_spot(new Cloud(50, 1, PointXYZ(1, 2, 3)));
  const auto at_a_point = alignWith(
      icp, one_spot, target, [](auto&) {}, identity);
  EXPECT_EQ(icp.getResult().degeneracy, Degeneracy::Point);
  EXPECT_TRUE(at_a_point.transformation.allFinite());

  Cloud::Ptr two(new Cloud(2, 1, PointXYZ(1, 2, 3)));
  alignWith(
      icp, two, target, [](auto&) {}, identity);
  EXPECT_FALSE(icp.hasConverged());
  EXPECT_EQ(icp.getResult().reason, Reason::NoCorrespondences);

  Cloud::Ptr all_nan(new Cloud(100, 1, PointXYZ(not_a_number, not_a_number, not_a_number)));
  alignWith(
      icp, all_nan, target, [](auto&) {}, identity);
  EXPECT_FALSE(icp.hasConverged());
  alignWith(
      icp, source, all_nan, [](auto&) {}, identity);
  EXPECT_FALSE(icp.hasConverged());
}

TEST_F(IcpBehaviour, ResultSaysWhatRan)
{
  icp.setPipeline(Pipeline::Staged);
  icp.setNumberOfThreads(2);
  alignWith(icp, source, target, twenty_iterations, identity);
  const auto& result = icp.getResult();
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.reason, Reason::Iterations);
  EXPECT_EQ(result.iterations, 20);
  EXPECT_EQ(result.inliers, source->size());
  EXPECT_LT(result.rmse, result.rmse_before);
  EXPECT_NEAR(result.rmse * result.rmse, icp.getFitnessScore(), 0.05 * icp.getFitnessScore());
  EXPECT_EQ(result.pipeline, Pipeline::Staged);
  EXPECT_EQ(result.threads, 2U);
  EXPECT_FALSE(result.device.name.empty());
  for (const char* stage : {"gather", "centroid", "demean", "cross_covariance", "svd", "rigid_transform", "upload"})
    EXPECT_EQ(result.device_times.count(stage), 1U) << stage;
  for (const char* step : {"tree", "start", "search", "estimate", "total"})
    EXPECT_EQ(result.host_times.count(step), 1U) << step;
  ASSERT_EQ(result.requests.size(), 5U);
  EXPECT_EQ(result.requests[0].work_items.front(), source->size());
  EXPECT_EQ(result.requests[0].work_items.back(), 1U);
  EXPECT_EQ(result.requests[3].work_items.front(), 27U);
}

TEST_F(IcpBehaviour, PipelinesAgree)
{
  const auto fused = alignWith(icp, source, target, twenty_iterations, identity);
  Icp staged;
  staged.setPipeline(Pipeline::Staged);
  EXPECT_LT(
      (alignWith(staged, source, target, twenty_iterations, identity).transformation - fused.transformation).norm(),
      1e-6);
}

TEST_F(IcpBehaviour, FarFromTheOriginTheTransformKeepsItsDigits)
{
  // 10 km away: what stock PCL's float loses there is 5 cm.
  const Eigen::Affine3f far(Eigen::Translation3f(10000, -5000, 100));
  const auto far_target = scenes::moved(*target, far);
  const Eigen::Affine3f by = Eigen::Translation3f(0.05F, 0.02F, 0) * Eigen::AngleAxisf(1e-5F, Eigen::Vector3f::UnitZ());
  const auto far_source = scenes::moved(*far_target, by.inverse());
  const auto outcome = alignWith(icp, far_source, far_target, twenty_iterations, identity);
  double sum = 0;
  for (std::size_t i = 0; i < far_target->size(); ++i) {
    const Eigen::Matrix4d transformation = outcome.transformation.cast<double>();
    const Eigen::Vector3d moved =
        transformation.topLeftCorner<3, 3>() * (*far_source)[i].getVector3fMap().cast<double>() +
        transformation.topRightCorner<3, 1>();
    sum += (moved - (*far_target)[i].getVector3fMap().cast<double>()).squaredNorm();
  }
  EXPECT_LT(std::sqrt(sum / double(far_target->size())), 2e-3);
}

TEST_F(IcpBehaviour, SeveralAlignersOnSeveralThreads)
{
  const auto expected = alignWith(icp, source, target, twenty_iterations, identity);
  std::vector<Eigen::Matrix4f> transformations(4);
  std::vector<std::thread> threads;
  for (auto& transformation : transformations)
    threads.emplace_back([&, this] {
      Icp own;
      transformation = alignWith(own, source, target, twenty_iterations, identity).transformation;
    });
  for (auto& thread : threads)
    thread.join();
  for (const auto& transformation : transformations)
    EXPECT_EQ(transformation, expected.transformation);
}

TEST_F(IcpBehaviour, WithDefaultCriteriaEveryAlignmentEnds)
{
  // Where the matches stay the same the pose stands still but for float32's last digits.
  for (unsigned seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    target = scenes::hills<PointXYZ>(300 + 100 * seed, 2 * seed + 1);
    source = scenes::moved(*scenes::hills<PointXYZ>(250 + 50 * seed, 2 * seed + 2), scenes::smallMotion());
    for (const CorrespondenceSearch search : {CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree})
      for (const Pipeline pipeline : {Pipeline::Fused, Pipeline::Staged}) {
        Icp other;
        other.setCorrespondenceSearch(search);
        other.setPipeline(pipeline);
        alignWith(
            other, source, target, [](auto& aligner) { aligner.setMaximumIterations(1000); }, identity);
        EXPECT_EQ(other.getResult().reason, Reason::AbsoluteMse);
        EXPECT_LT(other.getResult().iterations, 200);
        // The matches are the final ones: an iteration more would search for none.
        EXPECT_EQ(other.getResult().searched.back(), 0U);
      }
  }
}

TEST_F(IcpBehaviour, AndersonAccelerationReachesTheSameEndInFewerIterations)
{
  target = scenes::hills<PointXYZ>(50000);
  for (const CorrespondenceSearch search : {CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree})
    for (const bool rejecting : {false, true}) {
      const auto toTheEnd = [&](auto& icp) {
        icp.setCorrespondenceSearch(search);
        icp.setMaximumIterations(500);
        icp.setTransformationEpsilon(1e-10);
        if (rejecting) {
          const auto trimmed = pcl::make_shared<pcl::registration::CorrespondenceRejectorTrimmed>();
          trimmed->setOverlapRatio(0.9F);
          icp.addCorrespondenceRejector(trimmed);
        }
      };
      Icp plain, accelerated;
      accelerated.setAndersonAcceleration(true);
      const auto expected = alignWith(plain, source, target, toTheEnd, identity);
      const auto actual = alignWith(accelerated, source, target, toTheEnd, identity);
      EXPECT_TRUE(actual.converged);
      EXPECT_LT(accelerated.getResult().iterations, 0.7 * plain.getResult().iterations);
      EXPECT_EQ(accelerated.getResult().searched.size(), std::size_t(accelerated.getResult().iterations));
      EXPECT_LT(accelerated.getResult().rmse, 1.01 * plain.getResult().rmse);
      // Target points are 18 mm apart: fixed points lie closer together than that.
      EXPECT_LT(scenes::metresBetween<float>(actual.transformation, expected.transformation), 4e-3);
      EXPECT_LT(scenes::degreesBetween<float>(actual.transformation, expected.transformation), 0.1);
    }
}

TEST_F(IcpBehaviour, TheDeviceHoldsAtMost120BytesAPoint)
{
  const std::size_t points = 100000;
  source = scenes::hills<PointXYZ>(points, 2);
  target = scenes::hills<PointXYZ>(points);
  Eigen::Matrix4f found[2];
  for (const CorrespondenceSearch search : {CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree}) {
    icp.setCorrespondenceSearch(search);
    found[search == CorrespondenceSearch::DeviceKdTree] =
        alignWith(icp, source, target, twenty_iterations, identity).transformation;
    EXPECT_LE(icp.getResult().device_bytes, 120 * points);
    // Coordinates of both clouds, at the least.
    EXPECT_GE(icp.getResult().device_bytes, 24 * points);
    Icp listing;
    listing.setCorrespondenceSearch(search);
    alignWith(
        listing,
        source,
        target,
        [](auto& icp) {
          icp.setMaximumIterations(2);
          icp.addCorrespondenceRejector(pcl::make_shared<pcl::registration::CorrespondenceRejectorTrimmed>());
        },
        identity);
    EXPECT_GT(listing.getResult().device_bytes, icp.getResult().device_bytes);
  }
  EXPECT_LT((found[0] - found[1]).norm(), 1e-6);
}
