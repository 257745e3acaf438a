#pragma once

#include <pcl_gpu_icp/loss.h>

#include <vector>

namespace pcl_gpu_icp {

/// The standard deviation of a normally distributed number from the median of its absolute values, so that a minority
/// of others does not count; 0 where there are none.
///
/// \param residuals infinite where there is none: these are taken out, and the rest is in another order after
double robustDeviation(std::vector<float>& residuals);

/// The scale that a loss takes from the residuals, see Loss; 1 where all are 0.
///
/// \param residuals as for robustDeviation()
double scaleFrom(std::vector<float>& residuals, LossFunction function);

} // namespace pcl_gpu_icp
