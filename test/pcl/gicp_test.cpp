// pcl_gpu_icp::GeneralizedIterativeClosestPoint in place of PCL's: at the minimum of the same cost, by every setting.
#include "scans.h"

#include <pcl_gpu_icp/gicp.h>
#include <pcl_gpu_icp/icp.h>

#include <pcl/common/transforms.h>
#include <pcl/registration/correspondence_estimation.h>
#include <pcl/registration/correspondence_rejection_trimmed.h>
#include <pcl/registration/transformation_estimation_lm.h>

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <random>

namespace pcl_gpu_icp::test {
namespace {

using pcl::PointXYZ;
using Cloud = pcl::PointCloud<PointXYZ>;
using Ours = GeneralizedIterativeClosestPoint<PointXYZ, PointXYZ>;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Matrix4f;
using Eigen::Vector3d;

/// Lets the covariances be seen.
struct Stock : pcl::GeneralizedIterativeClosestPoint<PointXYZ, PointXYZ> {
  using Matrices = MatricesVector;
  const MatricesVectorPtr& ofSource() const { return input_covariances_; }
  const MatricesVectorPtr& ofTarget() const { return target_covariances_; }
};

/// A bumpy surface, which holds every motion fast.
Cloud::Ptr bumps(unsigned seed = 1, int n = 1500)
{
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> across(-5, 5), off(-0.002F, 0.002F);
  Cloud::Ptr cloud(new Cloud);
  for (int i = 0; i < n; ++i) {
    const float x = across(engine), y = across(engine);
    cloud->push_back({x, y, std::sin(x) * std::cos(0.7F * y) + 0.1F * x * y + off(engine)});
  }
  return cloud;
}

Matrix4f motion(float degrees, const Eigen::Vector3f& shift)
{
  Matrix4f matrix = Matrix4f::Identity();
  matrix.topLeftCorner<3, 3>() =
      Eigen::AngleAxisf(degrees * static_cast<float>(M_PI) / 180, Eigen::Vector3f(1, 2, 3).normalized())
          .toRotationMatrix();
  matrix.topRightCorner<3, 1>() = shift;
  return matrix;
}

Cloud::Ptr moved(const Cloud& cloud, const Matrix4f& by)
{
  Cloud::Ptr result(new Cloud);
  pcl::transformPointCloud(cloud, *result, by);
  return result;
}

/// Mean squared Mahalanobis distance, in double, of the pairs that are nearest to each other and nearer than `limit`
/// with the source at `matched_at`, whose rotation they are weighed by too.
double costOf(const Cloud& source,
              const Cloud& target,
              const Matrix4d& pose,
              const Matrix4d& matched_at,
              const Stock& with,
              double limit)
{
  pcl::search::KdTree<PointXYZ> tree;
  tree.setInputCloud(target.makeShared());
  const Matrix3d R = matched_at.topLeftCorner<3, 3>();
  const auto at = [&](const Matrix4d& place, const PointXYZ& point) -> Vector3d {
    return place.topLeftCorner<3, 3>() * point.getVector3fMap().cast<double>() + place.topRightCorner<3, 1>();
  };
  double sum = 0;
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Vector3d p = at(matched_at, source[i]);
    pcl::Indices index(1);
    std::vector<float> distance(1);
    tree.nearestKSearch(
        {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}, 1, index, distance);
    if (distance[0] >= limit * limit)
      continue;
    const Vector3d e = target[index[0]].getVector3fMap().cast<double>() - at(pose, source[i]);
    sum += e.dot(((*with.ofTarget())[index[0]] + R * (*with.ofSource())[i] * R.transpose()).inverse() * e);
    ++pairs;
  }
  return sum / static_cast<double>(pairs);
}

template <typename Icp>
Matrix4f
align(Icp& icp, const Cloud::Ptr& source, const Cloud::Ptr& target, const Matrix4f& guess = Matrix4f::Identity())
{
  icp.setInputSource(source);
  icp.setInputTarget(target);
  Cloud output;
  icp.align(output, guess);
  return icp.getFinalTransformation();
}

/// How far apart two poses bring the points at most.
double apart(const Cloud& cloud, const Matrix4f& a, const Matrix4f& b)
{
  double most = 0;
  for (const PointXYZ& point : cloud)
    most = std::max<double>(most, ((a - b) * point.getVector4fMap()).head<3>().norm());
  return most;
}

class Generalized : public testing::TestWithParam<CorrespondenceSearch> {
protected:
  void SetUp() override { icp_.setCorrespondenceSearch(GetParam()); }

  const Cloud::Ptr target_ = bumps();
  const Matrix4f truth_ = motion(2, {0.1F, -0.05F, 0.08F});
  const Cloud::Ptr source_ = moved(*target_, truth_.inverse());
  Ours icp_;
};

TEST_P(Generalized, FindsTheMotionThroughPclsBaseClasses)
{
  pcl::GeneralizedIterativeClosestPoint<PointXYZ, PointXYZ>& base = icp_;
  EXPECT_LT(apart(*source_, align(base, source_, target_), truth_), 1e-4);
  EXPECT_TRUE(base.hasConverged());
  EXPECT_LT(base.getFitnessScore(), 1e-8);
  const AlignmentResult& result = icp_.getResult();
  EXPECT_EQ(result.metric, Metric::Generalized);
  EXPECT_EQ(result.reason, Reason::Transform);
  EXPECT_EQ(result.search, GetParam());
  pcl::Registration<PointXYZ, PointXYZ>& registration = icp_;
  EXPECT_LT(apart(*source_, align(registration, source_, target_), truth_), 1e-4);
}

// The weights depend on the rotation and the pairs on the pose; a step of either class takes both for fixed.
TEST_P(Generalized, CostIsBelowStocksForStocksOwnPairs)
{
  if (!scans::areThere())
    GTEST_SKIP() << "no scans in " << scans::folder;
  struct {
    const char *source, *target;
    float leaf;
  } const pairs[] = {{"lidar_street_1.pcd", "lidar_street_0.pcd", 0.25F},
                     {"rgbd_room_1.pcd", "rgbd_room_0.pcd", 0.05F},
                     {"bunny_45.pcd", "bunny_0.pcd", 0}};
  for (const auto& pair : pairs) {
    SCOPED_TRACE(pair.source);
    const Cloud::Ptr source = scans::read(pair.source, pair.leaf), target = scans::read(pair.target, pair.leaf);
    Stock stock;
    const Matrix4f theirs = align(stock, source, target);
    icp_.setMaximumIterations(200);
    const Matrix4f ours = align(icp_, source, target);
    icp_.setMaximumIterations(1);
    const Matrix4f further = align(icp_, source, target, theirs);
    const auto cost = [&](const Matrix4f& pose, const Matrix4f& matched_at) {
      return costOf(*source,
                    *target,
                    pose.cast<double>(),
                    matched_at.cast<double>(),
                    stock,
                    stock.getMaxCorrespondenceDistance());
    };
    EXPECT_LT(cost(further, theirs), cost(theirs, theirs)) << "stock is short of the minimum for its own last pairs";
    // Of pairs and weights as they are at each one's end.
    EXPECT_LE(cost(ours, ours), 1.03 * cost(theirs, theirs));
  }
}

TEST_P(Generalized, StreetEndsAboutAsNearToTheReferenceAsStock)
{
  if (!scans::areThere())
    GTEST_SKIP() << "no scans in " << scans::folder;
  Matrix4d reference;
  std::ifstream file(scans::folder / "lidar_street_T_0_1.txt");
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      file >> reference(row, column);
  ASSERT_TRUE(file);
  for (const float leaf : {0.0F, 0.25F}) {
    SCOPED_TRACE(leaf);
    const auto read = [&](const char* name) {
      const Cloud::Ptr cloud = scans::read(name), kept(new Cloud);
      for (const PointXYZ& point : *cloud)
        if (point.x != 0 || point.y != 0 || point.z != 0)
          kept->push_back(point);
      if (leaf == 0)
        return kept;
      Cloud::Ptr thinned(new Cloud);
      pcl::VoxelGrid<PointXYZ> grid;
      grid.setLeafSize(leaf, leaf, leaf);
      grid.setInputCloud(kept);
      grid.filter(*thinned);
      return thinned;
    };
    const Cloud::Ptr source = read("lidar_street_1.pcd"), target = read("lidar_street_0.pcd");
    const auto error = [&](const Matrix4f& pose) {
      return (pose.cast<double>() - reference).topRightCorner<3, 1>().norm();
    };
    Stock stock;
    EXPECT_LE(error(align(icp_, source, target)), error(align(stock, source, target)) + (leaf == 0 ? 0.001 : 0.003));
  }
}

TEST_P(Generalized, GivenCovariancesAreThoseThatCount)
{
  // Those that stock comes to are what ours come to as well.
  const Cloud::Ptr target = bumps(2);
  Stock stock;
  align(stock, source_, target);
  const Matrix4f own = align(icp_, source_, target);
  icp_.setInputSource(source_);
  icp_.setInputTarget(target);
  icp_.setSourceCovariances(stock.ofSource());
  icp_.setTargetCovariances(stock.ofTarget());
  Cloud output;
  icp_.align(output);
  EXPECT_LT(apart(*source_, icp_.getFinalTransformation(), own), 1e-4);
  // Others lead elsewhere: those of balls, to plain ICP's end.
  const auto balls = pcl::make_shared<Stock::Matrices>(source_->size(), Matrix3d::Identity());
  icp_.setSourceCovariances(balls);
  icp_.setTargetCovariances(balls);
  icp_.setTransformationEpsilon(1e-9);
  icp_.setRotationEpsilon(1e-9);
  icp_.align(output);
  IterativeClosestPoint<PointXYZ, PointXYZ> points;
  points.setMaximumIterations(500);
  points.setMaxCorrespondenceDistance(icp_.getMaxCorrespondenceDistance());
  EXPECT_LT(apart(*source_, icp_.getFinalTransformation(), align(points, source_, target)), 1e-3);
  EXPECT_GT(apart(*source_, icp_.getFinalTransformation(), own), 1e-3);
}

TEST_P(Generalized, CovariancesThatAreNoneAreAnError)
{
  icp_.setInputSource(source_);
  icp_.setInputTarget(target_);
  icp_.setSourceCovariances(pcl::make_shared<Stock::Matrices>(3, Matrix3d::Identity()));
  Cloud output;
  icp_.align(output);
  EXPECT_FALSE(icp_.hasConverged());
  EXPECT_EQ(icp_.getResult().message,
            "the covariances of the source are 3, its points " + std::to_string(source_->size()));
  EXPECT_GT(icp_.getFitnessScore(), 0) << "at the guess";
  const auto odd = pcl::make_shared<Stock::Matrices>(source_->size(), Matrix3d::Identity());
  (*odd)[7](0, 1) = std::numeric_limits<double>::quiet_NaN();
  icp_.setSourceCovariances(odd);
  icp_.align(output);
  EXPECT_EQ(icp_.getResult().message, "covariance 7 of the source is not finite");
  (*odd)[7] = Eigen::DiagonalMatrix<double, 3>(1, 1, -0.1);
  icp_.align(output);
  EXPECT_EQ(icp_.getResult().message, "covariance 7 of the source has a negative eigenvalue");
  (*odd)[7] = Eigen::DiagonalMatrix<double, 3>(1, 1, 0); // a plane without noise
  icp_.align(output);
  EXPECT_TRUE(icp_.hasConverged()) << icp_.getResult().message;
  icp_.setSourceCovariances(pcl::make_shared<Stock::Matrices>(source_->size(), Matrix3d::Zero()));
  icp_.setTargetCovariances(pcl::make_shared<Stock::Matrices>(target_->size(), Matrix3d::Zero()));
  icp_.align(output);
  EXPECT_FALSE(icp_.hasConverged());
  EXPECT_NE(icp_.getResult().message.find("covariances"), std::string::npos) << icp_.getResult().message;
}

TEST_P(Generalized, NeighboursCount)
{
  const Cloud::Ptr target = bumps(2);
  const Matrix4f from_twenty = align(icp_, source_, target);
  icp_.setCorrespondenceRandomness(8);
  EXPECT_GT(apart(*source_, align(icp_, source_, target), from_twenty), 1e-6);
  icp_.setCorrespondenceRandomness(20);
  EXPECT_EQ(align(icp_, source_, target), from_twenty);
  icp_.setCorrespondenceRandomness(2);
  align(icp_, source_, target);
  EXPECT_FALSE(icp_.hasConverged());
  EXPECT_NE(icp_.getResult().message.find("3 to 32"), std::string::npos) << icp_.getResult().message;
}

TEST_P(Generalized, EndsByPclsCriteria)
{
  icp_.setMaximumIterations(2);
  icp_.setTransformationEpsilon(1e-12);
  align(icp_, source_, target_);
  EXPECT_TRUE(icp_.hasConverged());
  EXPECT_EQ(icp_.getResult().reason, Reason::Iterations);
  EXPECT_EQ(icp_.getResult().iterations, 2);
  icp_.setMaximumIterations(200);
  icp_.setTransformationEpsilon(0.05);
  icp_.setRotationEpsilon(0.05);
  align(icp_, source_, target_, truth_);
  EXPECT_EQ(icp_.getResult().iterations, 1) << "from the answer no entry changes by a twentieth";
  EXPECT_EQ(icp_.getResult().reason, Reason::Transform);
}

TEST_P(Generalized, LimitAndGuessAndIndicesKeepPclsMeaning)
{
  icp_.setMaxCorrespondenceDistance(1e-6);
  align(icp_, source_, target_);
  EXPECT_EQ(icp_.getResult().reason, Reason::NoCorrespondences);
  EXPECT_FALSE(icp_.hasConverged());
  EXPECT_LT(apart(*source_, align(icp_, source_, target_, truth_), truth_), 1e-4) << "near enough from the answer";
  icp_.setMaxCorrespondenceDistance(5);

  // A part of the source, the rest of which is elsewhere.
  Cloud::Ptr both(new Cloud(*source_));
  for (int i = 0; i < 300; ++i)
    both->push_back({0.3F * static_cast<float>(i % 17), 3, 4});
  const auto indices = pcl::make_shared<pcl::Indices>();
  for (std::size_t i = 0; i < source_->size(); ++i)
    indices->push_back(static_cast<pcl::index_t>(i));
  icp_.setIndices(indices);
  EXPECT_LT(apart(*source_, align(icp_, both, target_), truth_), 1e-4);
  EXPECT_EQ(icp_.getResult().source_points, source_->size());
}

TEST_P(Generalized, PairsAtTheLimitItselfAreNoneAsInPcl)
{
  // A lattice, so that distances are exactly one.
  Cloud::Ptr lattice(new Cloud), shifted(new Cloud);
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j) {
      const auto x = static_cast<float>(i), y = static_cast<float>(j);
      lattice->push_back({4 * x, 4 * y, 0});
      shifted->push_back({4 * x, 4 * y, 1});
    }
  for (const double limit : {1.0, std::nextafter(1.0, 2.0)}) {
    Stock stock;
    icp_.setMaxCorrespondenceDistance(limit);
    stock.setMaxCorrespondenceDistance(limit);
    align(icp_, shifted, lattice);
    align(stock, shifted, lattice);
    EXPECT_EQ(icp_.getResult().reason != Reason::NoCorrespondences, limit > 1);
    EXPECT_EQ(stock.getFinalTransformation() != Matrix4f::Identity(), limit > 1) << "PCL itself";
  }
}

TEST_P(Generalized, IndicesThatAreNoneAreReadByNobody)
{
  icp_.setIndices(pcl::make_shared<pcl::Indices>(pcl::Indices{0, 99999}));
  align(icp_, source_, target_);
  EXPECT_FALSE(icp_.hasConverged());
  EXPECT_EQ(icp_.getFitnessScore(), std::numeric_limits<double>::max());
}

TEST_P(Generalized, RejectorsAndReciprocityAreHonoured)
{
  // A third of the source is a lump that belongs nowhere.
  Cloud::Ptr source(new Cloud(*source_));
  std::mt19937 engine(3);
  std::uniform_real_distribution<float> in(-0.5F, 0.5F);
  for (int i = 0; i < 500; ++i)
    source->push_back({1 + in(engine), 1 + in(engine), 3 + in(engine)});
  const double disturbed = apart(*source_, align(icp_, source, target_), truth_);
  const auto trimmed = pcl::make_shared<pcl::registration::CorrespondenceRejectorTrimmed>();
  trimmed->setOverlapRatio(0.7F);
  icp_.addCorrespondenceRejector(trimmed);
  EXPECT_LT(apart(*source_, align(icp_, source, target_), truth_), 1e-3);
  EXPECT_EQ(icp_.getResult().inliers, 1400U);
  icp_.clearCorrespondenceRejectors();
  icp_.setUseReciprocalCorrespondences(true);
  EXPECT_LT(apart(*source_, align(icp_, source, target_), truth_), disturbed);
  EXPECT_LT(icp_.getResult().inliers, source->size());
}

TEST_P(Generalized, WhatWouldBeIgnoredIsRefusedByName)
{
  const auto refused = [&](const char* what) {
    align(icp_, source_, target_);
    EXPECT_FALSE(icp_.hasConverged()) << what;
    EXPECT_EQ(icp_.getResult().reason, Reason::Error) << what;
    EXPECT_NE(icp_.getResult().message.find("generalized ICP excludes"), std::string::npos) << icp_.getResult().message;
    EXPECT_EQ(icp_.getFinalTransformation(), Matrix4f::Identity());
  };
  icp_.setTransformationEstimation(
      pcl::make_shared<pcl::registration::TransformationEstimationLM<PointXYZ, PointXYZ>>());
  refused("estimator");
  icp_.setMetric(Metric::Generalized);
  align(icp_, source_, target_);
  EXPECT_TRUE(icp_.hasConverged());
  icp_.setSearchMethodTarget(pcl::make_shared<pcl::search::KdTree<PointXYZ>>());
  refused("search");
}

TEST_P(Generalized, SameBitsEveryTimeAndAfterOtherMetrics)
{
  IterativeClosestPoint<PointXYZ, PointXYZ> icp;
  icp.setCorrespondenceSearch(GetParam());
  const Cloud::Ptr target = bumps(2);
  const auto trimmed = pcl::make_shared<pcl::registration::CorrespondenceRejectorTrimmed>();
  trimmed->setOverlapRatio(0.999F);
  const auto answers = [&] {
    std::vector<Matrix4f> all;
    for (const Metric metric : {Metric::Point, Metric::Generalized, Metric::Plane})
      for (const bool listed : {false, true}) {
        icp.setMetric(metric);
        EXPECT_EQ(icp.getMetric(), metric);
        icp.clearCorrespondenceRejectors();
        if (listed)
          icp.addCorrespondenceRejector(trimmed);
        all.push_back(align(icp, source_, target));
        EXPECT_EQ(icp.getResult().metric, metric);
        EXPECT_EQ(icp.getResult().message, "");
      }
    return all;
  };
  const auto first = answers(), second = answers();
  EXPECT_EQ(first, second);
  EXPECT_NE(first[0], first[2]);
  EXPECT_NE(first[2], first[4]);
  for (const Matrix4f& answer : first)
    EXPECT_LT(apart(*source_, answer, truth_), 0.05);
}

TEST_P(Generalized, SourceOfAnotherAlignmentLeavesNothingBehind)
{
  const Cloud::Ptr other = moved(*bumps(5, 900), truth_.inverse());
  Ours fresh;
  fresh.setCorrespondenceSearch(GetParam());
  const Matrix4f expected = align(fresh, other, target_);
  align(icp_, source_, target_);
  EXPECT_EQ(align(icp_, other, target_), expected);
}

TEST_P(Generalized, DoubleIsARotationToDoublesDigits)
{
  GeneralizedIterativeClosestPoint<PointXYZ, PointXYZ, double> icp;
  icp.setCorrespondenceSearch(GetParam());
  icp.setInputSource(source_);
  icp.setInputTarget(target_);
  Cloud output;
  icp.align(output);
  const Matrix3d R = icp.getFinalTransformation().topLeftCorner<3, 3>();
  EXPECT_LT((R * R.transpose() - Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_LT(apart(*source_, icp.getFinalTransformation().cast<float>(), truth_), 1e-4);
}

TEST_P(Generalized, PointsThatTakeNoPartChangeNothing)
{
  const Matrix4f expected = align(icp_, source_, target_);
  constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
  Cloud::Ptr source(new Cloud(*source_)), target(new Cloud(*target_));
  source->push_back({not_a_number, 0, 0});
  target->push_back({0, std::numeric_limits<float>::infinity(), 0});
  source->is_dense = target->is_dense = false;
  EXPECT_LT(apart(*source_, align(icp_, source, target), expected), 1e-6);
  EXPECT_EQ(icp_.getResult().source_dropped, 1U);
}

TEST_P(Generalized, VisualizerSeesEachIteration)
{
  int seen = 0;
  std::function<typename Ours::UpdateVisualizerCallbackSignature> callback =
      [&](const Cloud&, const pcl::Indices& from, const Cloud&, const pcl::Indices& to) {
        ++seen;
        EXPECT_EQ(from.size(), to.size());
      };
  icp_.registerVisualizationCallback(callback);
  align(icp_, source_, target_);
  EXPECT_EQ(seen, icp_.getResult().iterations + 1) << "pcl::Registration shows the start as well";
  EXPECT_GT(seen, 2);
}

/// PCL 1.13's test/registration/test_registration.cpp, GeneralizedIterativeClosestPoint.
TEST_P(Generalized, PclsOwnTest)
{
  if (!scans::areThere())
    GTEST_SKIP() << "no scans in " << scans::folder;
  const Cloud::Ptr source = scans::read("bunny_0.pcd"), target = scans::read("bunny_45.pcd");
  icp_.setMaximumIterations(50);
  icp_.setTransformationEpsilon(1e-8);
  align(icp_, source, target);
  EXPECT_LT(icp_.getFitnessScore(), 0.0001);
  icp_.setTransformationEpsilon(1e-6);
  // From other starts, about z.
  for (const double turn : {0.25, -0.25}) {
    Matrix4f guess = Matrix4f::Identity();
    guess.topLeftCorner<3, 3>() =
        Eigen::AngleAxisf(static_cast<float>(turn) * 0.5F, Eigen::Vector3f::UnitZ()).toRotationMatrix();
    const Cloud::Ptr turned = moved(*source, guess);
    Ours icp;
    icp.setCorrespondenceSearch(GetParam());
    icp.setMaximumIterations(50);
    icp.setTransformationEpsilon(1e-8);
    align(icp, turned, source);
    EXPECT_LT(icp.getFitnessScore(), 0.0001);
  }
}

INSTANTIATE_TEST_SUITE_P(,
                         Generalized,
                         testing::Values(CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree),
                         [](const auto& info) { return info.index == 0 ? "pcl" : "device"; });

} // namespace
} // namespace pcl_gpu_icp::test
