#pragma once

#include "cl.h"

namespace pcl_gpu_icp::opencl {

/// Tells isCompilingKernels() of something that OpenCL compiles, as long as it lives.
class Compilation {
public:
  /// A program that is built.
  Compilation();
  /// A kernel whose first launch has to wait until it is compiled, as PoCL does it. \param launch outlives this object
  explicit Compilation(const cl::Event& launch);
  ~Compilation();
  Compilation(const Compilation&) = delete;
  Compilation& operator=(const Compilation&) = delete;

  bool isRunning() const;

private:
  const cl::Event* launch_ = nullptr;
};

} // namespace pcl_gpu_icp::opencl
