#pragma once

#include <mutex>

namespace pcl_gpu_icp::opencl {

/// Held by whoever asks OpenCL for its platforms, devices, a context, a program or a queue. PoCL (3.1) starts at the
/// first of these without a guard: those who ask meanwhile are told that there is no device, or crash. \throws
/// DeviceError in a child process whose parent used OpenCL before fork()
[[nodiscard]] std::unique_lock<std::mutex> enterGate();

} // namespace pcl_gpu_icp::opencl
