// How exact an estimate is far from the origin, against what PCL's float estimator makes of the same pairs.
#include "estimator_cases.h"

#include <cstdlib>
#include <iostream>

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

} // namespace

using PrecisionFarOut = WithEstimator;

TEST_P(PrecisionFarOut, PerfectPairsOfASlab)
{
  const std::size_t n = std::min<std::size_t>(100'000, device().mostPoints());
  for (const double offset : {0.0, 1e2, 1e3, 1e4, 5e5}) {
    SCOPED_TRACE(testing::Message() << offset << " m from the origin");
    Random random(42);
    const Cloud source = random.cloud(n, {10, 10, 1.5}, {offset, offset, 0});
    const Isometry3d truth = motion({0.2, -0.1, 1}, 0.05, {0.5, -0.3, 0.2});
    const Cloud target = moved(source, truth);
    const Estimate result = estimate(source, target);
    const double error = rmsDifference(isometryOf(result.transform), truth, source);
    const auto handed_out = rounded<float>(result.transform, result.sourceCentroid());
    const double handed_out_error = rmsDifference(isometryOf(handed_out), truth, source);
    RecordProperty("rms_error_" + std::to_string(int(offset)) + "_m", std::to_string(error));
    if (std::getenv("PRINT_PRECISION"))
      std::cout << GetParam().name() << " " << offset << " m: " << error << ", as float " << handed_out_error
                << ", stock " << rmsDifference(stockFloat(source, target), truth, source) << "\n";
    if (offset == 0) {
      EXPECT_LE(error, 1e-5);
      EXPECT_LE(handed_out_error, 1e-5);
      continue;
    }
    const double stock = rmsDifference(stockFloat(source, target), truth, source);
    EXPECT_LE(error, stock);
    EXPECT_LE(handed_out_error, stock);
    if (offset == 1e4 && n >= 100'000) {
      EXPECT_LE(error, stock / 500);
    }
    // The table of what was measured, with room for another device's order of sums.
    const double measured = offset == 1e2 ? 4e-6 : offset == 1e3 ? 5e-6 : offset == 1e4 ? 2.6e-5 : 1.6e-3;
    if (n >= 100'000) {
      EXPECT_LE(error, 2 * measured);
    }
  }
}

RUN_EVERY_KERNEL_ESTIMATOR(PrecisionFarOut);

} // namespace pcl_gpu_icp::test
