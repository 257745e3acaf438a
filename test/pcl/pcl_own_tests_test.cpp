// What PCL 1.13's own tests of its registration (test_registration, test_registration_api,
// test_correspondence_rejectors) ask of its classes, asked of ours.
#include "scans.h"
#include "scenes.h"

#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/search/kdtree.h>
#include <pcl_gpu_icp/transformation_estimation_point_to_plane_lls.h>
#include <pcl_gpu_icp/transformation_estimation_svd.h>

#include <pcl/registration/correspondence_estimation.h>
#include <pcl/registration/correspondence_rejection_median_distance.h>
#include <pcl/registration/correspondence_rejection_sample_consensus.h>

#include <gtest/gtest.h>

#include <random>

using pcl::PointNormal;
using pcl::PointXYZ;
using Cloud = pcl::PointCloud<PointXYZ>;
using Icp = pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ>;
using pcl::registration::CorrespondenceRejectorMedianDistance;
using pcl::registration::CorrespondenceRejectorSampleConsensus;
using pcl_gpu_icp::CorrespondenceSearch;

namespace {

class Random {
public:
  explicit Random(unsigned seed)
  : generator_(seed)
  {
  }
  float upTo(float limit) { return std::uniform_real_distribution<float>(0, limit)(generator_); }
  Eigen::Affine3f motion(float angle, float distance)
  {
    const Eigen::Vector3f axis = Eigen::Vector3f(upTo(1), upTo(1), upTo(1)).normalized();
    const Eigen::Vector3f by = distance * Eigen::Vector3f(upTo(1), upTo(1), upTo(1));
    return Eigen::Translation3f(by) * Eigen::AngleAxisf(upTo(angle), axis);
  }

private:
  std::mt19937 generator_;
};

/// The bunny at 45 and at 0 degrees, or hills of its size.
struct Bunny {
  Cloud::Ptr source, target;
  Bunny()
  {
    if (scans::areThere()) {
      source = scans::read("bunny_45.pcd");
      target = scans::read("bunny_0.pcd");
      return;
    }
    std::cout << "without the bunny of " << scans::folder << ": hills of its size\n";
    const Eigen::Affine3f scale(Eigen::Scaling(0.04F));
    target = scenes::moved(*scenes::hills<PointXYZ>(400), scale);
    source = scenes::moved(*scenes::moved(*scenes::hills<PointXYZ>(360, 2), scenes::smallMotion()), scale);
  }
};

class PclsIcp : public testing::TestWithParam<CorrespondenceSearch> {
protected:
  PclsIcp() { icp.setCorrespondenceSearch(GetParam()); }
  Icp icp;
  Bunny bunny;
  Cloud aligned;
};

/// A curved surface. For exact pairs any normals will do: these spread more than its own.
pcl::PointCloud<PointNormal> surface()
{
  pcl::PointCloud<PointNormal> cloud;
  for (float x = -5; x <= 5; x += 0.5F)
    for (float y = -5; y <= 5; y += 0.5F) {
      PointNormal point;
      point.getVector3fMap() = Eigen::Vector3f(x, y, 0.1F * x * x + 0.2F * x * y - 0.3F * y + 1);
      point.getNormalVector3fMap() = Eigen::Vector3f(-0.2F * x - 0.2F, 0.6F * y - 0.2F, 1).normalized();
      cloud.push_back(point);
    }
  return cloud;
}

} // namespace

TEST_P(PclsIcp, FiveFarPointsThatWereShifted)
{
  Random random(1);
  const Cloud::Ptr from(new Cloud);
  for (int i = 0; i < 5; ++i)
    from->emplace_back(random.upTo(1024), random.upTo(1024), random.upTo(1024));
  icp.setInputSource(from);
  icp.setInputTarget(scenes::moved(*from, Eigen::Affine3f(Eigen::Translation3f(0.7F, 0, 0))));
  icp.align(aligned);
  ASSERT_TRUE(icp.hasConverged());
  EXPECT_LT(icp.getFitnessScore(), 1e-6);
  const Eigen::Vector3f by = icp.getFinalTransformation().topRightCorner<3, 1>();
  EXPECT_LT((by - Eigen::Vector3f(0.7F, 0, 0)).cwiseAbs().maxCoeff(), 2e-3);
}

TEST_P(PclsIcp, TheBunny)
{
  const auto configure = [&](auto& aligner) {
    aligner.setInputSource(bunny.source);
    aligner.setInputTarget(bunny.target);
    aligner.setMaximumIterations(50);
    aligner.setTransformationEpsilon(1e-8);
    aligner.setMaxCorrespondenceDistance(0.05);
    aligner.align(aligned);
    return aligner.getFinalTransformation();
  };
  pcl::IterativeClosestPoint<PointXYZ, PointXYZ> stock;
  const Eigen::Matrix4f expected = configure(stock), actual = configure(icp);
  EXPECT_EQ(aligned.size(), bunny.source->size());
  EXPECT_LT((actual - expected).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_EQ(actual.row(3), Eigen::RowVector4f(0, 0, 0, 1));
}

TEST_P(PclsIcp, WithRejectorsAnywhereInSpace)
{
  icp.setMaximumIterations(50);
  icp.setTransformationEpsilon(1e-8);
  icp.setMaxCorrespondenceDistance(0.15);
  const auto median = pcl::make_shared<CorrespondenceRejectorMedianDistance>();
  median->setMedianFactor(4);
  icp.addCorrespondenceRejector(median);
  icp.addCorrespondenceRejector(pcl::make_shared<CorrespondenceRejectorSampleConsensus<PointXYZ>>());
  Random random(2);
  for (int i = 0; i < 10; ++i) {
    const Eigen::Affine3f offset = random.motion(0, 0.05F), anywhere = random.motion(2 * float(M_PI), 10);
    icp.setInputSource(scenes::moved(*bunny.source, offset.inverse() * anywhere));
    icp.setInputTarget(scenes::moved(*bunny.source, anywhere));
    icp.align(aligned);
    const Eigen::Matrix4f difference = icp.getFinalTransformation() - offset.matrix();
    EXPECT_LT((difference.topRightCorner<3, 1>().cwiseAbs().maxCoeff()), 1e-2);
    EXPECT_LT((difference.topLeftCorner<3, 3>().cwiseAbs().maxCoeff()), 1e-1);
  }
}

// A tree that is cached holds the right cloud already; one that is not may hold a wrong one.
TEST_P(PclsIcp, WithEveryWayToCacheTheTrees)
{
  icp.setCorrespondenceSearch(CorrespondenceSearch::PclKdTree); // the device's excludes a tree of the caller's
  icp.setInputSource(bunny.source);
  icp.setInputTarget(bunny.target);
  icp.setMaximumIterations(50);
  icp.setTransformationEpsilon(1e-8);
  for (const bool reciprocal : {false, true})
    for (const bool target_cached : {false, true})
      for (const bool source_cached : {false, true}) {
        const auto of = [](const Cloud::Ptr& cloud) {
          const auto tree = pcl::make_shared<pcl::search::KdTree<PointXYZ>>();
          tree->setInputCloud(cloud);
          return tree;
        };
        icp.setUseReciprocalCorrespondences(reciprocal);
        icp.setSearchMethodTarget(of(target_cached ? bunny.target : bunny.source), target_cached);
        icp.setSearchMethodSource(of(source_cached ? bunny.source : bunny.target), source_cached);
        icp.align(aligned);
        EXPECT_EQ(aligned.size(), bunny.source->size());
        EXPECT_LT(icp.getFitnessScore(), 1e-3);
      }
}

INSTANTIATE_TEST_SUITE_P(,
                         PclsIcp,
                         testing::Values(CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree),
                         [](const auto& info) {
                           return std::string(toString(info.param)) == "pcl" ? "Pcl" : "Device";
                         });

TEST(PclsIcpToPlanes, TheBunny)
{
  Bunny bunny;
  using PointToPlane = pcl_gpu_icp::TransformationEstimationPointToPlaneLLS<PointXYZ, PointXYZ>;
  Icp icp;
  icp.setTransformationEstimation(pcl::make_shared<PointToPlane>());
  icp.setInputSource(bunny.source);
  icp.setInputTarget(bunny.target);
  icp.setMaximumIterations(50);
  icp.setTransformationEpsilon(1e-8);
  Cloud aligned;
  icp.align(aligned);
  EXPECT_EQ(aligned.size(), bunny.source->size());
  EXPECT_LT(icp.getFitnessScore(), 5e-3);
}

// Squared distances 0, 1, 4, ..., 100: twice their median, 50, leaves the first eight.
TEST(PclsRejectors, MedianDistanceInTheAligner)
{
  struct Listing : pcl::registration::TransformationEstimationSVD<PointXYZ, PointXYZ> {
    void estimateRigidTransformation(const Cloud&,
                                     const Cloud&,
                                     const pcl::Correspondences& correspondences,
                                     Matrix4& matrix) const override
    {
      handed = correspondences;
      matrix.setIdentity();
    }
    using pcl::registration::TransformationEstimationSVD<PointXYZ, PointXYZ>::estimateRigidTransformation;
    mutable pcl::Correspondences handed;
  };
  const Cloud::Ptr from(new Cloud), onto(new Cloud);
  for (int i = 0; i <= 10; ++i) {
    onto->emplace_back(100.0F * static_cast<float>(i), 0, 0);
    from->emplace_back(100.0F * static_cast<float>(i), static_cast<float>(i), 0);
  }
  for (const auto search : {CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree}) {
    const auto median = pcl::make_shared<CorrespondenceRejectorMedianDistance>();
    median->setMedianFactor(2);
    const auto listing = pcl::make_shared<Listing>();
    Icp icp;
    icp.setCorrespondenceSearch(search);
    icp.addCorrespondenceRejector(median);
    icp.setTransformationEstimation(listing);
    icp.setInputSource(from);
    icp.setInputTarget(onto);
    icp.setMaximumIterations(1);
    Cloud aligned;
    icp.align(aligned);
    ASSERT_EQ(listing->handed.size(), 8U);
    for (int i = 0; i < 8; ++i) {
      EXPECT_EQ(listing->handed[i].index_query, i);
      EXPECT_EQ(listing->handed[i].index_match, i);
      EXPECT_EQ(listing->handed[i].distance, static_cast<float>(i * i));
    }
  }
}

TEST(PclsCorrespondences, AreTheSameWithOurTree)
{
  Bunny bunny;
  const auto found = [&](bool ours, bool reciprocal) {
    pcl::registration::CorrespondenceEstimation<PointXYZ, PointXYZ> estimation;
    if (ours) {
      estimation.setSearchMethodTarget(pcl::make_shared<pcl_gpu_icp::search::KdTree<PointXYZ>>());
      estimation.setSearchMethodSource(pcl::make_shared<pcl_gpu_icp::search::KdTree<PointXYZ>>());
    }
    estimation.setInputSource(bunny.source);
    estimation.setInputTarget(bunny.target);
    pcl::Correspondences correspondences;
    if (reciprocal)
      estimation.determineReciprocalCorrespondences(correspondences);
    else
      estimation.determineCorrespondences(correspondences);
    return correspondences;
  };
  for (const bool reciprocal : {false, true}) {
    const auto expected = found(false, reciprocal), actual = found(true, reciprocal);
    ASSERT_EQ(actual.size(), expected.size());
    EXPECT_EQ(actual.size() < bunny.source->size(), reciprocal);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(actual[i].index_query, expected[i].index_query);
      EXPECT_EQ(actual[i].index_match, expected[i].index_match);
    }
  }
}

template <typename Scalar>
class PclsEstimators : public testing::Test {
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(PclsEstimators, Scalars);

TYPED_TEST(PclsEstimators, SvdOfExactPairs)
{
  using Matrix4 = Eigen::Matrix<TypeParam, 4, 4>;
  const Bunny bunny;
  const Eigen::Affine3f motion =
      Eigen::Translation3f(0.1F, -0.2F, 0.3F) * Eigen::AngleAxisf(0.4F, Eigen::Vector3f(1, 2, -3).normalized());
  const auto moved = scenes::moved(*bunny.target, motion);
  pcl::Correspondences correspondences;
  for (int i = 0; i < static_cast<int>(moved->size()); ++i)
    correspondences.emplace_back(i, i, 0.0F);
  const pcl_gpu_icp::TransformationEstimationSVD<PointXYZ, PointXYZ, TypeParam> estimator;
  Matrix4 by_position, by_correspondences;
  estimator.estimateRigidTransformation(*bunny.target, *moved, by_position);
  estimator.estimateRigidTransformation(*bunny.target, *moved, correspondences, by_correspondences);
  EXPECT_LT((by_position - motion.matrix().cast<TypeParam>()).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_EQ(by_position, by_correspondences);
}

TYPED_TEST(PclsEstimators, PointToPlaneOfASurface)
{
  using Matrix4 = Eigen::Matrix<TypeParam, 4, 4>;
  Eigen::Affine3f motion = Eigen::Translation3f(0.1F, -0.2F, 0.3F) *
                           Eigen::AngleAxisf(-0.1F, Eigen::Vector3f::UnitZ()) *
                           Eigen::AngleAxisf(0.05F, Eigen::Vector3f::UnitY());
  const auto from = surface();
  auto onto = from;
  for (PointNormal& point : onto) {
    point.getVector3fMap() = motion * Eigen::Vector3f(point.getVector3fMap());
    point.getNormalVector3fMap() = motion.linear() * Eigen::Vector3f(point.getNormalVector3fMap());
  }
  const pcl_gpu_icp::TransformationEstimationPointToPlaneLLS<PointNormal, PointNormal, TypeParam> estimator;
  Matrix4 found;
  estimator.estimateRigidTransformation(from, onto, found);
  EXPECT_LT((found - motion.matrix().cast<TypeParam>()).cwiseAbs().maxCoeff(), 1e-2);
}
