#pragma once

#include "cl.h"

#include <pcl_gpu_icp/device.h>

namespace pcl_gpu_icp::opencl {

/// What a Device holds.
struct DeviceHandle {
  DeviceInfo info;
  cl::Device device;
};

/// Whether it is one of PoCL's, the OpenCL implementation for CPUs.
inline bool isPocl(const DeviceInfo& info) { return info.platform == "Portable Computing Language"; }

/// Whether this is a child process whose parent used OpenCL before fork().
bool usedBeforeFork() noexcept;

/// Throws DeviceError in such a child process. Called before each use of OpenCL, which would hang there.
void refuseAfterFork();

} // namespace pcl_gpu_icp::opencl
