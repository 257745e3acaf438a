#pragma once

#include "cl.h"

#include <pcl_gpu_icp/error.h>

#include <string>

namespace pcl_gpu_icp::opencl {

/// OpenCL's name of an error code, e.g. -5 -> "CL_OUT_OF_RESOURCES".
const char* codeName(int code) noexcept;

/// The function that an exception of the OpenCL bindings is of, which they call by other names here and there.
std::string callName(const char* name);

/// Runs `call` and turns an exception of the OpenCL bindings into a DeviceError that names kernel and device.
template <typename Call>
auto translated(const std::string& device, const std::string& kernel, Call&& call) -> decltype(call())
{
  try {
    return call();
  } catch (const cl::Error& error) {
    DeviceError::Where where{error.err(), callName(error.what()), kernel, device};
    throw DeviceError(where, "");
  }
}

} // namespace pcl_gpu_icp::opencl
