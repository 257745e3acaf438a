// Stage 3 alone: H from de-meaned pairs.
#include "stages/cross_covariance.h"

#include "stage_rig.h"

namespace pcl_gpu_icp::test {

using stages::CrossCovariance;

TEST(CrossCovarianceRequest, HalvesUntilOneIsLeft)
{
  EXPECT_EQ(CrossCovariance::request(5).stage, "cross_covariance");
  EXPECT_EQ(CrossCovariance::request(5).work_items, (std::vector<std::size_t>{5, 3, 2, 1}));
  EXPECT_EQ(CrossCovariance::request(1).work_items, std::vector<std::size_t>{1});
}

class CrossCovarianceStage : public OnDevice {
protected:
  /// H of de-meaned points as the stage computes it.
  Eigen::Matrix3d covarianceOf(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target)
  {
    const auto n = static_cast<std::size_t>(source.cols());
    rig_.pairs.count = static_cast<cl_uint>(n);
    rig_.pairs.stride = stages::paddedStride(n);
    std::vector<double> rows(PAIR_ROWS * rig_.pairs.stride, 0.0);
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < n; ++i) {
        rows[axis * rig_.pairs.stride + i] = source(axis, i);
        rows[(3 + axis) * rig_.pairs.stride + i] = target(axis, i);
      }
    rig_.writeReals(demeaned_, rows);
    rig_.writeSolution({});
    rig_.queue.takeProfile();
    stage_.enqueue(rig_.queue, rig_.pairs, demeaned_, rig_.realBytes(), rig_.solution);
    launches_ = rig_.queue.takeProfile().entries.at("cross_covariance").count;
    return matrixOf(rig_.readSolution().H);
  }

  unsigned launches_ = 0;

private:
  StageRig rig_{GetParam()};
  opencl::Buffer demeaned_{"de-meaned points"};
  CrossCovariance stage_;
};

TEST_P(CrossCovarianceStage, IsTheSumOfOuterProducts)
{
  for (const std::size_t n : GetParam().sizes()) {
    SCOPED_TRACE(n);
    Random random(3000 + n);
    const Eigen::Matrix3Xd source = random.cloud(n).cast<double>();
    const Eigen::Matrix3Xd target = random.cloud(n, {5, 4, 3}, {0.5, 0, -1}).cast<double>();
    const Eigen::Matrix3d expected = source * target.transpose();
    const double magnitude = source.norm() * target.norm();
    EXPECT_LE((covarianceOf(source, target) - expected).cwiseAbs().maxCoeff(), 4 * GetParam().epsilon() * magnitude);
    if (!GetParam().inPasses()) { // each of which is a launch
      EXPECT_EQ(launches_, CrossCovariance::request(n).work_items.size() + 1);
    }
  }
}

TEST_P(CrossCovarianceStage, RowsBelongToTheSourceAndColumnsToTheTarget)
{
  Eigen::Matrix3Xd source = Eigen::Matrix3Xd::Zero(3, 1), target = source;
  source(0, 0) = 2;
  target(2, 0) = 5;
  Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
  expected(0, 2) = 10;
  EXPECT_EQ(covarianceOf(source, target), expected);
}

RUN_WITH_EVERY_KERNEL(CrossCovarianceStage);

} // namespace pcl_gpu_icp::test
