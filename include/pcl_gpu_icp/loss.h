#pragma once

#include <pcl_gpu_icp/export.h>

#include <cmath>

namespace pcl_gpu_icp {

/// What a residual r costs, with c the scale, and how much its pair weighs for it. Without one r^2 and 1.
enum class LossFunction {
  None,
  Huber,        ///< r^2, beyond c 2 c |r| - c^2; weight c / |r| there (Huber 1964)
  Cauchy,       ///< c^2 log(1 + r^2 / c^2); weight 1 / (1 + r^2 / c^2)
  GemanMcClure, ///< r^2 / (1 + r^2 / c^2); weight 1 / (1 + r^2 / c^2)^2
  Tukey,        ///< (1 - (1 - r^2 / c^2)^3) c^2 / 3, beyond c c^2 / 3; weight (1 - r^2 / c^2)^2, beyond c 0
  Welsch,       ///< c^2 (1 - exp(-r^2 / c^2)); weight exp(-r^2 / c^2)
};

/// A robust loss: pairs that are far apart pull less. The weights act on the pairs of an iteration after they were
/// found. A residual is what the metric measures of a pair: the distance of the points or from point to plane, in the
/// clouds' unit, or of GICP the Mahalanobis distance.
struct Loss {
  LossFunction function = LossFunction::None;
  /// c. 0: of each iteration anew, the median of the residuals (beyond 16,384 of a sample) times 1.4826, which for a
  /// normal distribution is its standard deviation, times what keeps 95 % of the efficiency of least squares for
  /// one: 1.345 for Huber, 2.385 for Cauchy, 3.787 for Geman-McClure, 4.685 for Tukey, 2.985 for Welsch. Infinite: no
  /// loss.
  double scale = 0;

  /// Whether pairs weigh anything but 1.
  bool weighs() const { return function != LossFunction::None && !std::isinf(scale); }
};

PCL_GPU_ICP_API const char* toString(LossFunction function);

/// \throws InvalidArgument when the scale is negative or not a number, or its square is none that float32 holds
PCL_GPU_ICP_API void requireValid(const Loss& loss);

} // namespace pcl_gpu_icp
