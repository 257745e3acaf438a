#pragma once

#include "opencl/context.h"

#include <pcl_gpu_icp/neighbour_search.h>

namespace pcl_gpu_icp {

/// A NeighbourSearch whose kernels are adapted to other traits than the device's own: tests run every kernel shape on
/// every device.
NeighbourSearch makeNeighbourSearch(const Device& device, const opencl::Traits& traits);

} // namespace pcl_gpu_icp
