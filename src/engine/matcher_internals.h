#pragma once

#include "opencl/context.h"

#include <pcl_gpu_icp/matcher.h>

namespace pcl_gpu_icp {

/// A Matcher whose kernels are adapted to other traits than the device's own: tests run every kernel shape on every
/// device.
Matcher makeMatcher(const Device& device, const opencl::Traits& traits, Precision precision);

} // namespace pcl_gpu_icp
