#pragma once

#include "opencl/context.h"

#include <pcl_gpu_icp/normal_estimator.h>

namespace pcl_gpu_icp {

/// A NormalEstimator whose kernels are adapted to other traits than the device's own: tests run every kernel shape on
/// every device.
NormalEstimator makeNormalEstimator(const Device& device, const opencl::Traits& traits, Precision precision);

} // namespace pcl_gpu_icp
