#include "error.h"

#include <map>
#include <utility>

namespace pcl_gpu_icp {

namespace opencl {

const char* codeName(int code) noexcept
{
#define PCL_GPU_ICP_CODE(name)                                                                                         \
  case name:                                                                                                           \
    return #name;
  switch (code) {
    PCL_GPU_ICP_CODE(CL_SUCCESS)
    PCL_GPU_ICP_CODE(CL_DEVICE_NOT_FOUND)
    PCL_GPU_ICP_CODE(CL_DEVICE_NOT_AVAILABLE)
    PCL_GPU_ICP_CODE(CL_COMPILER_NOT_AVAILABLE)
    PCL_GPU_ICP_CODE(CL_MEM_OBJECT_ALLOCATION_FAILURE)
    PCL_GPU_ICP_CODE(CL_OUT_OF_RESOURCES)
    PCL_GPU_ICP_CODE(CL_OUT_OF_HOST_MEMORY)
    PCL_GPU_ICP_CODE(CL_PROFILING_INFO_NOT_AVAILABLE)
    PCL_GPU_ICP_CODE(CL_MEM_COPY_OVERLAP)
    PCL_GPU_ICP_CODE(CL_IMAGE_FORMAT_MISMATCH)
    PCL_GPU_ICP_CODE(CL_IMAGE_FORMAT_NOT_SUPPORTED)
    PCL_GPU_ICP_CODE(CL_BUILD_PROGRAM_FAILURE)
    PCL_GPU_ICP_CODE(CL_MAP_FAILURE)
    PCL_GPU_ICP_CODE(CL_MISALIGNED_SUB_BUFFER_OFFSET)
    PCL_GPU_ICP_CODE(CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST)
    PCL_GPU_ICP_CODE(CL_COMPILE_PROGRAM_FAILURE)
    PCL_GPU_ICP_CODE(CL_LINKER_NOT_AVAILABLE)
    PCL_GPU_ICP_CODE(CL_LINK_PROGRAM_FAILURE)
    PCL_GPU_ICP_CODE(CL_DEVICE_PARTITION_FAILED)
    PCL_GPU_ICP_CODE(CL_KERNEL_ARG_INFO_NOT_AVAILABLE)
    PCL_GPU_ICP_CODE(CL_INVALID_VALUE)
    PCL_GPU_ICP_CODE(CL_INVALID_DEVICE_TYPE)
    PCL_GPU_ICP_CODE(CL_INVALID_PLATFORM)
    PCL_GPU_ICP_CODE(CL_INVALID_DEVICE)
    PCL_GPU_ICP_CODE(CL_INVALID_CONTEXT)
    PCL_GPU_ICP_CODE(CL_INVALID_QUEUE_PROPERTIES)
    PCL_GPU_ICP_CODE(CL_INVALID_COMMAND_QUEUE)
    PCL_GPU_ICP_CODE(CL_INVALID_HOST_PTR)
    PCL_GPU_ICP_CODE(CL_INVALID_MEM_OBJECT)
    PCL_GPU_ICP_CODE(CL_INVALID_IMAGE_FORMAT_DESCRIPTOR)
    PCL_GPU_ICP_CODE(CL_INVALID_IMAGE_SIZE)
    PCL_GPU_ICP_CODE(CL_INVALID_SAMPLER)
    PCL_GPU_ICP_CODE(CL_INVALID_BINARY)
    PCL_GPU_ICP_CODE(CL_INVALID_BUILD_OPTIONS)
    PCL_GPU_ICP_CODE(CL_INVALID_PROGRAM)
    PCL_GPU_ICP_CODE(CL_INVALID_PROGRAM_EXECUTABLE)
    PCL_GPU_ICP_CODE(CL_INVALID_KERNEL_NAME)
    PCL_GPU_ICP_CODE(CL_INVALID_KERNEL_DEFINITION)
    PCL_GPU_ICP_CODE(CL_INVALID_KERNEL)
    PCL_GPU_ICP_CODE(CL_INVALID_ARG_INDEX)
    PCL_GPU_ICP_CODE(CL_INVALID_ARG_VALUE)
    PCL_GPU_ICP_CODE(CL_INVALID_ARG_SIZE)
    PCL_GPU_ICP_CODE(CL_INVALID_KERNEL_ARGS)
    PCL_GPU_ICP_CODE(CL_INVALID_WORK_DIMENSION)
    PCL_GPU_ICP_CODE(CL_INVALID_WORK_GROUP_SIZE)
    PCL_GPU_ICP_CODE(CL_INVALID_WORK_ITEM_SIZE)
    PCL_GPU_ICP_CODE(CL_INVALID_GLOBAL_OFFSET)
    PCL_GPU_ICP_CODE(CL_INVALID_EVENT_WAIT_LIST)
    PCL_GPU_ICP_CODE(CL_INVALID_EVENT)
    PCL_GPU_ICP_CODE(CL_INVALID_OPERATION)
    PCL_GPU_ICP_CODE(CL_INVALID_GL_OBJECT)
    PCL_GPU_ICP_CODE(CL_INVALID_BUFFER_SIZE)
    PCL_GPU_ICP_CODE(CL_INVALID_MIP_LEVEL)
    PCL_GPU_ICP_CODE(CL_INVALID_GLOBAL_WORK_SIZE)
    PCL_GPU_ICP_CODE(CL_INVALID_PROPERTY)
    PCL_GPU_ICP_CODE(CL_INVALID_IMAGE_DESCRIPTOR)
    PCL_GPU_ICP_CODE(CL_INVALID_COMPILER_OPTIONS)
    PCL_GPU_ICP_CODE(CL_INVALID_LINKER_OPTIONS)
    PCL_GPU_ICP_CODE(CL_INVALID_DEVICE_PARTITION_COUNT)
  case -1001:
    return "CL_PLATFORM_NOT_FOUND_KHR";
  default:
    return "unknown OpenCL error";
  }
#undef PCL_GPU_ICP_CODE
}

std::string callName(const char* name)
{
  static const std::map<std::string, std::string> others{{"clGetEventProfileInfo", "clGetEventProfilingInfo"},
                                                         {"clEnqueueUnMapMemObject", "clEnqueueUnmapMemObject"},
                                                         {"Retain Object", "clRetain..."},
                                                         {"Release Object", "clRelease..."}};
  const auto found = others.find(name);
  return found == others.end() ? name : found->second;
}

} // namespace opencl

namespace {

std::string describe(const DeviceError::Where& where, const std::string& advice)
{
  std::string text;
  if (where.code != 0) {
    text = (where.call.empty() ? std::string("OpenCL") : where.call) + " failed with " + opencl::codeName(where.code) +
           " (" + std::to_string(where.code) + ")";
    if (!where.kernel.empty())
      text += " for kernel " + where.kernel;
    if (!where.device.empty())
      text += " on " + where.device;
  }
  if (!advice.empty())
    text += (text.empty() ? "" : ": ") + advice;
  return text;
}

} // namespace

DeviceError::DeviceError(const Where& where, const std::string& advice)
: Error(describe(where, advice))
, where_(where)
{
}

const char* DeviceError::codeName() const noexcept { return opencl::codeName(where_.code); }

KernelBuildError::KernelBuildError(const Where& where, std::string options, std::string log)
: DeviceError(where, "options \"" + options + "\"; compiler output: " + log)
, options_(std::move(options))
, log_(std::move(log))
{
}

} // namespace pcl_gpu_icp
