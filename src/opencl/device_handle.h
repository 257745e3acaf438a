#pragma once

#include "cl.h"

#include <pcl_gpu_icp/device.h>

namespace pcl_gpu_icp::opencl {

/// What a Device holds.
struct DeviceHandle {
  DeviceInfo info;
  cl::Device device;
};

/// Throws DeviceError in a child process whose parent used OpenCL before fork().
void refuseAfterFork();

} // namespace pcl_gpu_icp::opencl
