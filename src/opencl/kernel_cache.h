#pragma once

#include <string>

namespace pcl_gpu_icp::opencl {

/// Where PoCL keeps the kernels that it compiles, and files that it needs while it does.
struct KernelCache {
  std::string directory;
  std::string obstacle; ///< why that cannot be used and what to do; empty: it can
  bool is_ours = false; ///< not where PoCL would look by itself, but where POCL_CACHE_DIR has to point
};

/// The folder that PoCL would choose: what POCL_CACHE_DIR or XDG_CACHE_HOME says, or one in HOME. Where nobody said,
/// and that one cannot be written or is full, one of this user alone in the folder for temporary files.
KernelCache chooseKernelCache();

/// The choice of this process, which the first call makes and tells PoCL of. Called before OpenCL is.
const KernelCache& kernelCache();

} // namespace pcl_gpu_icp::opencl
