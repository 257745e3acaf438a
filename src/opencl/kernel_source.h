#pragma once

#include <string>

namespace pcl_gpu_icp::opencl {

/// The text of a kernel file with the shared headers it includes put in their place. Files are those embedded at
/// build time, or those of the directory that the environment variable PCL_GPU_ICP_KERNEL_DIR names (for developing
/// kernels).
/// \throws InvalidArgument when there is no such file
std::string kernelSource(const std::string& file);

} // namespace pcl_gpu_icp::opencl
