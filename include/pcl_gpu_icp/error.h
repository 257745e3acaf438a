#pragma once

#include <pcl_gpu_icp/export.h>

#include <stdexcept>
#include <string>

namespace pcl_gpu_icp {

/// Base of every exception thrown by this library.
class PCL_GPU_ICP_API Error : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// The caller passed something that no device could work with. Thrown before anything is enqueued.
class PCL_GPU_ICP_API InvalidArgument : public Error {
public:
  using Error::Error;
};

/// An OpenCL call failed, or no device answers to a selection.
class PCL_GPU_ICP_API DeviceError : public Error {
public:
  struct Where {
    int code = 0;       ///< OpenCL error code, e.g. -5; 0 when no call failed (a selection without a match)
    std::string call;   ///< OpenCL function, e.g. "clEnqueueNDRangeKernel"
    std::string kernel; ///< kernel name; empty when the call concerns none
    std::string device; ///< device name; empty when none had been chosen
  };

  /// what() reads "CALL failed with NAME (CODE) [for kernel KERNEL] [on DEVICE]: ADVICE".
  DeviceError(const Where& where, const std::string& advice);

  int code() const noexcept { return where_.code; }
  /// OpenCL's own name of code(), e.g. "CL_OUT_OF_RESOURCES".
  const char* codeName() const noexcept;
  const std::string& call() const noexcept { return where_.call; }
  const std::string& kernel() const noexcept { return where_.kernel; }
  const std::string& device() const noexcept { return where_.device; }

private:
  Where where_;
};

/// A kernel source did not compile on the chosen device.
class PCL_GPU_ICP_API KernelBuildError : public DeviceError {
public:
  KernelBuildError(const Where& where, std::string options, std::string log);

  const std::string& options() const noexcept { return options_; } ///< build options passed to the compiler
  const std::string& log() const noexcept { return log_; }         ///< the compiler's own output

private:
  std::string options_;
  std::string log_;
};

} // namespace pcl_gpu_icp
