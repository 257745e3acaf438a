// IterativeClosestPointNonLinear and IterativeClosestPointWithNormals in place of PCL's: the same answers.
#include <pcl_gpu_icp/icp_nl.h>
#include <pcl_gpu_icp/icp_with_normals.h>

#include <pcl/common/transforms.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace pcl_gpu_icp::test {
namespace {

using pcl::PointNormal;
using Cloud = pcl::PointCloud<PointNormal>;
using Eigen::Matrix4f;
using Eigen::Vector3f;

/// z = sin(x) cos(y / 2) + x y / 10, sampled at random, with its normals.
Cloud::Ptr bumps(unsigned seed)
{
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> across(-4, 4);
  Cloud::Ptr cloud(new Cloud);
  for (int i = 0; i < 2000; ++i) {
    const float x = across(engine), y = across(engine);
    PointNormal point;
    point.getVector3fMap() = Vector3f(x, y, std::sin(x) * std::cos(y / 2) + x * y / 10);
    point.getNormalVector3fMap() =
        Vector3f(-std::cos(x) * std::cos(y / 2) - y / 10, std::sin(x) * std::sin(y / 2) / 2 - x / 10, 1).normalized();
    cloud->push_back(point);
  }
  return cloud;
}

Matrix4f truth()
{
  Matrix4f matrix = Matrix4f::Identity();
  matrix.topLeftCorner<3, 3>() = Eigen::AngleAxisf(0.04F, Vector3f(1, -2, 2).normalized()).toRotationMatrix();
  matrix.topRightCorner<3, 1>() = Vector3f(0.05F, -0.04F, 0.06F);
  return matrix;
}

class IcpClasses : public testing::TestWithParam<CorrespondenceSearch> {
protected:
  IcpClasses() { pcl::transformPointCloudWithNormals(*bumps(2), *source_, Matrix4f(truth().inverse())); }

  template <typename Icp>
  Matrix4f align(Icp& icp, const Matrix4f& guess = Matrix4f::Identity()) const
  {
    icp.setInputSource(source_);
    icp.setInputTarget(target_);
    icp.setMaximumIterations(60);
    Cloud output;
    icp.align(output, guess);
    EXPECT_TRUE(icp.hasConverged());
    return icp.getFinalTransformation();
  }

  /// How far apart two poses bring the points at most.
  double apart(const Matrix4f& a, const Matrix4f& b) const
  {
    double most = 0;
    for (const PointNormal& point : *source_)
      most = std::max<double>(most, ((a - b) * point.getVector4fMap()).head<3>().norm());
    return most;
  }

  const Cloud::Ptr source_{new Cloud}, target_ = bumps(1);
};

// Stock's optimiser stops short of the least squares that it looks for.
TEST_P(IcpClasses, NonLinearEndsNoFartherThanStockAndWhereStockStays)
{
  pcl::IterativeClosestPointNonLinear<PointNormal, PointNormal> stock;
  IterativeClosestPointNonLinear<PointNormal, PointNormal> ours;
  ours.setCorrespondenceSearch(GetParam());
  pcl::IterativeClosestPoint<PointNormal, PointNormal>& base = ours;
  const Matrix4f answer = align(base);
  align(stock);
  EXPECT_LE(ours.getFitnessScore(), stock.getFitnessScore());
  EXPECT_LT(apart(align(stock, answer), answer), 2e-3);
  EXPECT_EQ(ours.getResult().metric, Metric::Point);
  EXPECT_GT(ours.getResult().device_bytes, 0U);
  EXPECT_GT(ours.getResult().device_times.size(), 0U);
}

TEST_P(IcpClasses, WithNormalsEndsWhereStockDoes)
{
  pcl::IterativeClosestPointWithNormals<PointNormal, PointNormal> stock;
  IterativeClosestPointWithNormals<PointNormal, PointNormal> ours;
  ours.setCorrespondenceSearch(GetParam());
  const Matrix4f answer = align(ours);
  EXPECT_LT(apart(answer, align(stock)), 1e-4);
  EXPECT_LT(apart(answer, truth()), 5e-3);
  EXPECT_EQ(ours.getResult().metric, Metric::Plane);
  EXPECT_EQ(ours.getMetric(), Metric::Plane);
}

TEST_P(IcpClasses, SymmetricObjectiveEndsWhereStocksDoesAndCanBeLeftAgain)
{
  pcl::IterativeClosestPointWithNormals<PointNormal, PointNormal> stock;
  IterativeClosestPointWithNormals<PointNormal, PointNormal> ours;
  ours.setCorrespondenceSearch(GetParam());
  const Matrix4f planes = align(ours);
  stock.setUseSymmetricObjective(true);
  ours.setUseSymmetricObjective(true);
  for (const bool same_direction : {true, false}) {
    stock.setEnforceSameDirectionNormals(same_direction);
    ours.setEnforceSameDirectionNormals(same_direction);
    EXPECT_LT(apart(align(ours), align(stock)), 1e-4);
    EXPECT_NE(ours.getFinalTransformation(), planes);
    EXPECT_EQ(ours.getResult().metric, same_direction ? Metric::Symmetric : Metric::Point);
  }
  ours.setEnforceSameDirectionNormals(true);
  align(ours);
  EXPECT_EQ(ours.getResult().metric, Metric::Symmetric);
  ours.setUseSymmetricObjective(false);
  EXPECT_EQ(align(ours), planes);
}

TEST_P(IcpClasses, NormalsThatNobodyComputedAreNoAnswer)
{
  const auto without_normals = [](const Cloud& cloud, float value) {
    const Cloud::Ptr changed(new Cloud(cloud));
    for (PointNormal& point : *changed)
      point.getNormalVector3fMap().setConstant(value);
    return changed;
  };
  const auto messageOf = [this](const Cloud::Ptr& source, const Cloud::Ptr& target, bool symmetric) {
    IterativeClosestPointWithNormals<PointNormal, PointNormal> icp;
    icp.setCorrespondenceSearch(GetParam());
    icp.setUseSymmetricObjective(symmetric);
    icp.setInputSource(source);
    icp.setInputTarget(target);
    Cloud output;
    icp.align(output);
    EXPECT_NE(icp.hasConverged(), icp.getResult().reason == Reason::Error);
    return icp.getResult().message;
  };
  for (const float value : {0.0F, std::numeric_limits<float>::quiet_NaN()})
    for (const bool symmetric : {false, true}) {
      EXPECT_EQ(
          messageOf(source_, without_normals(*target_, value), symmetric).find("no point of the target has a normal"),
          0U);
      EXPECT_EQ(
          messageOf(without_normals(*source_, value), target_, symmetric).find("no point of the source has a normal"),
          symmetric ? 0U : std::string::npos);
    }
  const Cloud::Ptr all_but_one = without_normals(*target_, 0);
  all_but_one->front() = target_->front();
  EXPECT_EQ(messageOf(source_, all_but_one, false), "");
}

TEST_P(IcpClasses, EveryClassHasEveryMetric)
{
  const auto endsAs = [&](auto& icp) {
    icp.setCorrespondenceSearch(GetParam());
    for (const Metric metric : {Metric::Plane, Metric::Generalized, Metric::Point, Metric::Plane}) {
      icp.setMetric(metric);
      EXPECT_LT(apart(align(icp), truth()), 0.05);
      EXPECT_EQ(icp.getResult().metric, metric);
      EXPECT_EQ(icp.getMetric(), metric);
    }
  };
  IterativeClosestPointNonLinear<PointNormal, PointNormal> non_linear;
  IterativeClosestPointWithNormals<PointNormal, PointNormal> with_normals;
  endsAs(non_linear);
  endsAs(with_normals);
}

INSTANTIATE_TEST_SUITE_P(,
                         IcpClasses,
                         testing::Values(CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree),
                         [](const auto& info) { return info.index == 0 ? "pcl" : "device"; });

} // namespace
} // namespace pcl_gpu_icp::test
