// The estimator on its own, in a plain PCL pipeline.
#include "scenes.h"

#include <pcl_gpu_icp/error.h>
#include <pcl_gpu_icp/transformation_estimation_svd.h>

#include <pcl/registration/icp.h>
#include <pcl/registration/transformation_estimation_svd.h>

#include <gtest/gtest.h>

#include <numeric>
#include <thread>

using pcl::PointXYZ;
using Cloud = pcl::PointCloud<PointXYZ>;
using pcl_gpu_icp::Pipeline;

namespace {

template <typename Scalar>
class Estimation : public testing::Test {
protected:
  using Matrix4 = Eigen::Matrix<Scalar, 4, 4>;
  using Ours = pcl_gpu_icp::TransformationEstimationSVD<PointXYZ, PointXYZ, Scalar>;
  using Stock = pcl::registration::TransformationEstimationSVD<PointXYZ, PointXYZ, Scalar>;

  Cloud::Ptr source = scenes::hills<PointXYZ>(1000);
  Eigen::Affine3f motion =
      Eigen::Translation3f(1, -2, 0.5F) * Eigen::AngleAxisf(1.2F, Eigen::Vector3f(1, 2, 3).normalized());
  Cloud::Ptr target = scenes::moved(*source, motion);
  const Ours ours;
  const Stock umeyama{true}, svd{false};
  const double tolerance = std::is_same<Scalar, double>::value ? 1e-6 : 1e-5;
};

using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Estimation, Scalars);

} // namespace

TYPED_TEST(Estimation, AllOverloadsGiveWhatStockGives)
{
  using Matrix4 = typename TestFixture::Matrix4;
  pcl::Indices forward(500), backward(500);
  std::iota(forward.begin(), forward.end(), 100);
  std::iota(backward.rbegin(), backward.rend(), 100);
  pcl::Correspondences correspondences;
  for (int i = 0; i < 300; ++i)
    correspondences.emplace_back(3 * i, 3 * i, 0.0F);
  Cloud::Ptr part(new Cloud(*this->target, forward));

  const auto run = [&](const auto& estimator, int overload) {
    Matrix4 matrix = Matrix4::Zero();
    if (overload == 0)
      estimator.estimateRigidTransformation(*this->source, *this->target, matrix);
    if (overload == 1)
      estimator.estimateRigidTransformation(*this->source, forward, *part, matrix);
    if (overload == 2)
      estimator.estimateRigidTransformation(*this->source, backward, *this->target, forward, matrix);
    if (overload == 3)
      estimator.estimateRigidTransformation(*this->source, *this->target, correspondences, matrix);
    return matrix;
  };
  for (int overload = 0; overload < 4; ++overload) {
    EXPECT_LT((run(this->ours, overload) - run(this->umeyama, overload)).norm(), this->tolerance) << overload;
    EXPECT_LT((run(this->ours, overload) - run(this->svd, overload)).norm(), this->tolerance) << overload;
  }
}

TYPED_TEST(Estimation, SizesThatDifferLeaveTheMatrix)
{
  using Matrix4 = typename TestFixture::Matrix4;
  const Matrix4 before = Matrix4::Constant(7);
  Matrix4 matrix = before;
  Cloud shorter(*this->target);
  shorter.resize(10);
  this->ours.estimateRigidTransformation(*this->source, shorter, matrix);
  EXPECT_EQ(matrix, before);
  this->ours.estimateRigidTransformation(*this->source, pcl::Indices(5, 0), shorter, matrix);
  EXPECT_EQ(matrix, before);
  this->ours.estimateRigidTransformation(*this->source, pcl::Indices(5, 0), shorter, pcl::Indices(6, 0), matrix);
  EXPECT_EQ(matrix, before);
}

TYPED_TEST(Estimation, NoPairsGiveTheIdentity)
{
  using Matrix4 = typename TestFixture::Matrix4;
  Matrix4 matrix = Matrix4::Zero();
  this->ours.estimateRigidTransformation(*this->source, *this->target, pcl::Correspondences(), matrix);
  EXPECT_EQ(matrix, Matrix4::Identity());
  EXPECT_EQ(this->ours.getEstimate().degeneracy, pcl_gpu_icp::Degeneracy::Empty);
}

TYPED_TEST(Estimation, IsARotation)
{
  typename TestFixture::Matrix4 matrix;
  this->ours.estimateRigidTransformation(*this->source, *this->target, matrix);
  const auto rotation = matrix.template topLeftCorner<3, 3>();
  const double digits = std::is_same<TypeParam, double>::value ? 1e-12 : 1e-6;
  EXPECT_LT((rotation.transpose() * rotation - Eigen::Matrix<TypeParam, 3, 3>::Identity()).norm(), digits);
  EXPECT_NEAR(rotation.determinant(), 1, digits);
}

TYPED_TEST(Estimation, SharedByThreads)
{
  using Matrix4 = typename TestFixture::Matrix4;
  Matrix4 expected;
  this->ours.estimateRigidTransformation(*this->source, *this->target, expected);
  std::vector<std::thread> threads;
  std::atomic<int> wrong{0};
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 25; ++i) {
        Matrix4 matrix;
        this->ours.estimateRigidTransformation(*this->source, *this->target, matrix);
        wrong += matrix == expected ? 0 : 1;
      }
    });
  for (auto& thread : threads)
    thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST(EstimationInStockIcp, GivesWhatStockGives)
{
  const auto target = scenes::hills<PointXYZ>(2000);
  const auto source = scenes::moved(*scenes::hills<PointXYZ>(1500, 2), scenes::smallMotion());
  const auto align = [&](bool with_ours) {
    pcl::IterativeClosestPoint<PointXYZ, PointXYZ> icp;
    if (with_ours) {
      using Estimator = pcl_gpu_icp::TransformationEstimationSVD<PointXYZ, PointXYZ>;
      Estimator::Ptr estimator(new Estimator);
      estimator->setPipeline(Pipeline::Staged);
      icp.setTransformationEstimation(estimator);
    }
    icp.setInputSource(source);
    icp.setInputTarget(target);
    icp.setMaximumIterations(20);
    Cloud output;
    icp.align(output);
    return icp.getFinalTransformation();
  };
  EXPECT_LT((align(true) - align(false)).norm(), 2e-5);
}

// As pcl::registration::TransformationEstimationSVD can be.
TYPED_TEST(Estimation, CanBeCopiedAndAssigned)
{
  using Matrix4 = typename TestFixture::Matrix4;
  using Ours = typename TestFixture::Ours;
  const auto run = [&](const Ours& estimator) {
    Matrix4 matrix;
    estimator.estimateRigidTransformation(*this->source, *this->target, matrix);
    return matrix;
  };
  Ours original;
  original.setPipeline(Pipeline::Staged);
  const Matrix4 expected = run(original);
  const Ours copy = original;
  EXPECT_EQ(copy.getPipeline(), Pipeline::Staged);
  EXPECT_EQ(copy.getEstimate().pairs, original.getEstimate().pairs);
  EXPECT_EQ(run(copy), expected);
  Ours assigned;
  run(assigned); // has an estimator for the other pipeline
  assigned = original;
  EXPECT_EQ(assigned.getPipeline(), Pipeline::Staged);
  EXPECT_EQ(run(assigned), expected);
  EXPECT_EQ(run(original), expected);
}

TEST(EstimationDevice, IsTheOneThatWasSet)
{
  const auto devices = pcl_gpu_icp::Device::list();
  ASSERT_FALSE(devices.empty());
  for (const auto& device : devices) {
    pcl_gpu_icp::TransformationEstimationSVD<PointXYZ, PointXYZ> estimator;
    estimator.setDevice(device);
    EXPECT_EQ(estimator.getDevice().info().name, device.info().name);
    const auto cloud = scenes::hills<PointXYZ>(100);
    Eigen::Matrix4f matrix;
    estimator.estimateRigidTransformation(*cloud, *cloud, matrix);
    EXPECT_LT((matrix - Eigen::Matrix4f::Identity()).norm(), 1e-6);
  }
}
