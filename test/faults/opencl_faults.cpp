// The OpenCL functions that the library imports, each of which may fail once.
#define CL_TARGET_OPENCL_VERSION 120
#define CL_USE_DEPRECATED_OPENCL_1_1_APIS
#include "fault_point.h"

#include <CL/cl.h>

#include <dlfcn.h>

namespace {

/// The function of that name that stands behind the one here.
template <typename Function>
Function* real(Function* /*its own*/, const char* name)
{
  // By name: a program whose calls end here does not need to be linked with it.
  static void* const library = dlopen("libOpenCL.so.1", RTLD_NOW);
  return reinterpret_cast<Function*>(dlsym(library, name));
}

template <typename Handle>
Handle failedHandle(cl_int* error, int code)
{
  if (error)
    *error = code;
  return nullptr;
}

template <typename Handle>
Handle created(const char* kind, Handle handle)
{
  if (handle)
    faults::countLive(kind, 1);
  return handle;
}

cl_int changed(const char* kind, long by, cl_int code)
{
  if (code == CL_SUCCESS)
    faults::countLive(kind, by);
  return code;
}

cl_int withEvent(const cl_event* event, cl_int code) { return event ? changed("event", 1, code) : code; }

} // namespace

#define REAL(name)                                                                                                     \
  (*[] {                                                                                                               \
    static const auto function = real(&name, #name);                                                                   \
    return function;                                                                                                   \
  }())
#define FAIL_WITH_CODE(name)                                                                                           \
  if (const int code = faults::failsNow(#name))                                                                        \
  return code
#define FAIL_WITH_NULL(name, Handle)                                                                                   \
  if (const int code = faults::failsNow(#name))                                                                        \
  return failedHandle<Handle>(error, code)

#define WITH_CODE(name, parameters, ...)                                                                               \
  cl_int name parameters                                                                                               \
  {                                                                                                                    \
    FAIL_WITH_CODE(name);                                                                                              \
    return REAL(name)(__VA_ARGS__);                                                                                    \
  }
#define CHANGES(name, Handle, kind, by)                                                                                \
  cl_int name(Handle handle)                                                                                           \
  {                                                                                                                    \
    FAIL_WITH_CODE(name);                                                                                              \
    return changed(kind, by, REAL(name)(handle));                                                                      \
  }

extern "C" {

WITH_CODE(clGetPlatformIDs, (cl_uint count, cl_platform_id* platforms, cl_uint* found), count, platforms, found)
WITH_CODE(clGetPlatformInfo,
          (cl_platform_id platform, cl_platform_info what, size_t bytes, void* value, size_t* needed),
          platform,
          what,
          bytes,
          value,
          needed)
WITH_CODE(clGetDeviceIDs,
          (cl_platform_id platform, cl_device_type type, cl_uint count, cl_device_id* devices, cl_uint* found),
          platform,
          type,
          count,
          devices,
          found)
WITH_CODE(clGetDeviceInfo,
          (cl_device_id device, cl_device_info what, size_t bytes, void* value, size_t* needed),
          device,
          what,
          bytes,
          value,
          needed)
WITH_CODE(
    clCreateSubDevices,
    (cl_device_id device, const cl_device_partition_property* how, cl_uint count, cl_device_id* parts, cl_uint* made),
    device,
    how,
    count,
    parts,
    made)
WITH_CODE(clBuildProgram,
          (cl_program program,
           cl_uint count,
           const cl_device_id* devices,
           const char* options,
           void(CL_CALLBACK* notify)(cl_program, void*),
           void* data),
          program,
          count,
          devices,
          options,
          notify,
          data)
WITH_CODE(clGetProgramInfo,
          (cl_program program, cl_program_info what, size_t bytes, void* value, size_t* needed),
          program,
          what,
          bytes,
          value,
          needed)
WITH_CODE(
    clGetProgramBuildInfo,
    (cl_program program, cl_device_id device, cl_program_build_info what, size_t bytes, void* value, size_t* needed),
    program,
    device,
    what,
    bytes,
    value,
    needed)
WITH_CODE(
    clSetKernelArg, (cl_kernel kernel, cl_uint index, size_t bytes, const void* value), kernel, index, bytes, value)
WITH_CODE(
    clGetKernelWorkGroupInfo,
    (cl_kernel kernel, cl_device_id device, cl_kernel_work_group_info what, size_t bytes, void* value, size_t* needed),
    kernel,
    device,
    what,
    bytes,
    value,
    needed)
WITH_CODE(clGetEventProfilingInfo,
          (cl_event event, cl_profiling_info what, size_t bytes, void* value, size_t* needed),
          event,
          what,
          bytes,
          value,
          needed)
WITH_CODE(clFinish, (cl_command_queue queue), queue)

CHANGES(clRetainDevice, cl_device_id, "device", 1)
CHANGES(clReleaseDevice, cl_device_id, "device", -1)
CHANGES(clRetainProgram, cl_program, "program", 1)
CHANGES(clReleaseProgram, cl_program, "program", -1)
CHANGES(clReleaseContext, cl_context, "context", -1)
CHANGES(clReleaseCommandQueue, cl_command_queue, "queue", -1)
CHANGES(clReleaseKernel, cl_kernel, "kernel", -1)
CHANGES(clReleaseMemObject, cl_mem, "buffer", -1)
CHANGES(clReleaseEvent, cl_event, "event", -1)

cl_context clCreateContext(const cl_context_properties* properties,
                           cl_uint count,
                           const cl_device_id* devices,
                           void(CL_CALLBACK* notify)(const char*, const void*, size_t, void*),
                           void* data,
                           cl_int* error)
{
  FAIL_WITH_NULL(clCreateContext, cl_context);
  return created("context", REAL(clCreateContext)(properties, count, devices, notify, data, error));
}

cl_command_queue
clCreateCommandQueue(cl_context context, cl_device_id device, cl_command_queue_properties properties, cl_int* error)
{
  FAIL_WITH_NULL(clCreateCommandQueue, cl_command_queue);
  return created("queue", REAL(clCreateCommandQueue)(context, device, properties, error));
}

cl_program
clCreateProgramWithSource(cl_context context, cl_uint count, const char** texts, const size_t* lengths, cl_int* error)
{
  FAIL_WITH_NULL(clCreateProgramWithSource, cl_program);
  return created("program", REAL(clCreateProgramWithSource)(context, count, texts, lengths, error));
}

cl_kernel clCreateKernel(cl_program program, const char* name, cl_int* error)
{
  FAIL_WITH_NULL(clCreateKernel, cl_kernel);
  return created("kernel", REAL(clCreateKernel)(program, name, error));
}

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t bytes, void* host, cl_int* error)
{
  FAIL_WITH_NULL(clCreateBuffer, cl_mem);
  return created("buffer", REAL(clCreateBuffer)(context, flags, bytes, host, error));
}

void* clEnqueueMapBuffer(cl_command_queue queue,
                         cl_mem buffer,
                         cl_bool waits,
                         cl_map_flags flags,
                         size_t offset,
                         size_t bytes,
                         cl_uint count,
                         const cl_event* before,
                         cl_event* event,
                         cl_int* error)
{
  FAIL_WITH_NULL(clEnqueueMapBuffer, void*);
  void* memory = REAL(clEnqueueMapBuffer)(queue, buffer, waits, flags, offset, bytes, count, before, event, error);
  if (memory && event)
    faults::countLive("event", 1);
  return memory;
}

cl_int clEnqueueUnmapMemObject(
    cl_command_queue queue, cl_mem buffer, void* memory, cl_uint count, const cl_event* before, cl_event* event)
{
  FAIL_WITH_CODE(clEnqueueUnmapMemObject);
  return withEvent(event, REAL(clEnqueueUnmapMemObject)(queue, buffer, memory, count, before, event));
}

cl_int clEnqueueReadBuffer(cl_command_queue queue,
                           cl_mem buffer,
                           cl_bool waits,
                           size_t offset,
                           size_t bytes,
                           void* to,
                           cl_uint count,
                           const cl_event* before,
                           cl_event* event)
{
  FAIL_WITH_CODE(clEnqueueReadBuffer);
  return withEvent(event, REAL(clEnqueueReadBuffer)(queue, buffer, waits, offset, bytes, to, count, before, event));
}

cl_int clEnqueueWriteBuffer(cl_command_queue queue,
                            cl_mem buffer,
                            cl_bool waits,
                            size_t offset,
                            size_t bytes,
                            const void* from,
                            cl_uint count,
                            const cl_event* before,
                            cl_event* event)
{
  FAIL_WITH_CODE(clEnqueueWriteBuffer);
  return withEvent(event, REAL(clEnqueueWriteBuffer)(queue, buffer, waits, offset, bytes, from, count, before, event));
}

cl_int clEnqueueNDRangeKernel(cl_command_queue queue,
                              cl_kernel kernel,
                              cl_uint dimensions,
                              const size_t* offset,
                              const size_t* global,
                              const size_t* local,
                              cl_uint count,
                              const cl_event* before,
                              cl_event* event)
{
  FAIL_WITH_CODE(clEnqueueNDRangeKernel);
  return withEvent(
      event, REAL(clEnqueueNDRangeKernel)(queue, kernel, dimensions, offset, global, local, count, before, event));
}

} // extern "C"
