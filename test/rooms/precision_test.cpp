// How exact an estimate is far from the origin, against what PCL's float estimator makes of the same pairs.
#include "estimator_cases.h"

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

/// pcl::registration::TransformationEstimationSVD<..., float>: Umeyama's method in float on raw coordinates.
Isometry3d stockFloat(const Cloud& source, const Cloud& target)
{
  // Of dynamic size: GCC 12 warns of the fixed-size ones inside Eigen.
  const Eigen::MatrixXf p = source, q = target;
  const Eigen::MatrixXf transform = Eigen::umeyama(p, q, false);
  return Isometry3d(Eigen::Matrix4d(transform.cast<double>()));
}

/// RMS errors in metres of 100k perfect pairs of a 20 m slab, as facts.md has them, and of the transform in float.
struct Row {
  double offset, error, error_in_float;
};
constexpr Row table[] = {
    {0, 7e-6, 7e-6}, {1e2, 4e-6, 8e-6}, {1e3, 5e-6, 1e-5}, {1e4, 2.6e-5, 4e-5}, {5e5, 1.6e-3, 2e-3}};

} // namespace

class PrecisionFarOut : public WithEstimator {
protected:
  /// \param about the point that the slab is turned about
  void expectTheTablesPrecision(const Row& row, const Vector3d& about)
  {
    const std::size_t n = device().affordable(100'000);
    Random random(42);
    const Cloud source = random.cloud(n, {10, 10, 1.5}, {row.offset, row.offset, 0});
    Isometry3d truth = motion({0.2, -0.1, 1}, 0.05, {0.5, -0.3, 0.2});
    truth.translation() += about - truth.linear() * about;
    const Cloud target = moved(source, truth);
    const Estimate result = estimate(source, target);
    const double error = rmsDifference(isometryOf(result.transform), truth, source);
    const auto in_float = rounded<float>(result.transform, result.sourceCentroid());
    const double error_in_float = rmsDifference(isometryOf(in_float), truth, source);
    const double stock = rmsDifference(stockFloat(source, target), truth, source);
    SCOPED_TRACE(testing::Message() << row.offset << " m from the origin: " << error << " m, in float "
                                    << error_in_float << " m, stock " << stock << " m");
    if (row.offset >= 100) {
      EXPECT_LE(error, stock);
      EXPECT_LE(error_in_float, stock);
    }
    if (n < 100'000)
      return;
    EXPECT_LE(error, row.error);
    EXPECT_LE(error_in_float, row.error_in_float);
    if (row.offset == 1e4) {
      EXPECT_LE(error, stock / 500);
      EXPECT_LE(error_in_float, stock / 500);
    }
  }
};

TEST_P(PrecisionFarOut, OfASlabTurnedAboutItsPlace)
{
  for (const Row& row : table)
    expectTheTablesPrecision(row, {row.offset, row.offset, 0});
}

TEST_P(PrecisionFarOut, OfASlabTurnedAboutTheOrigin)
{
  for (const Row& row : table)
    expectTheTablesPrecision(row, {0, 0, 0});
}

RUN_EVERY_KERNEL_ESTIMATOR(PrecisionFarOut);

} // namespace pcl_gpu_icp::test
