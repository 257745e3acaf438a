#pragma once

#include <pcl_gpu_icp/loss.h>

#include <vector>

namespace pcl_gpu_icp {

/// The scale that a loss takes from the residuals, see Loss; 1 where all are 0.
/// \param residuals as for robustDeviation()
double scaleFrom(std::vector<float>& residuals, LossFunction function);

} // namespace pcl_gpu_icp
