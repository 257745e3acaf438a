#pragma once

#include "opencl/context.h"

#include <pcl_gpu_icp/rigid_estimator.h>

namespace pcl_gpu_icp {

/// A RigidEstimator whose kernels are adapted to other traits than the device's own: tests and benchmarks run every
/// kernel shape on every device.
RigidEstimator
makeEstimator(const Device& device, const opencl::Traits& traits, Pipeline pipeline, Precision precision);

} // namespace pcl_gpu_icp
