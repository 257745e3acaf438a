#include "context.h"

#include "compilation.h"
#include "device_handle.h"
#include "error.h"
#include "gate.h"
#include "kernel_cache.h"
#include "kernel_source.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace pcl_gpu_icp::opencl {

Traits Traits::of(const DeviceInfo& info)
{
  Traits traits;
  // An embedded GPU's local memory may be ordinary memory too, but it still wants a work-item per point.
  // Mesa's CPU device runs work-items as lanes of its vectors, and Mesa 22.3 loses track of loops over 16-wide vectors.
  const bool is_mesa = info.platform == "rusticl";
  traits.shape = info.type == DeviceInfo::Type::Cpu && !is_mesa ? Shape::Chunked : Shape::Grouped;
  traits.mapped_memory = info.unified_memory;
  traits.fp64 = info.fp64;
  while (traits.work_group_size > 1 && traits.work_group_size > info.max_work_group_size)
    traits.work_group_size /= 2;
  traits.max_allocation = info.max_allocation;
  if (const char* limit = std::getenv("PCL_GPU_ICP_MAX_ALLOCATION"))
    traits.max_allocation = std::min<std::uint64_t>(traits.max_allocation, std::strtoull(limit, nullptr, 10));
  return traits;
}

Context& Context::of(const Device& device)
{
  const auto gate = enterGate();
  static auto& contexts = *new std::map<cl_device_id, Context*>;
  Context*& context = contexts[device.handle_->device()];
  if (!context)
    context = new Context(device);
  return *context;
}

Context::Context(const Device& device)
: device_(device)
, context_(translated(device.info().name, "", [&] { return cl::Context(device.handle_->device); }))
{
  if (isPocl(info()) && !kernelCache().obstacle.empty())
    throw DeviceError({}, kernelCache().obstacle);
}

const cl::Device& Context::device() const { return device_.handle_->device; }

cl::Program Context::program(const std::string& file, const std::string& options)
{
  const auto gate = enterGate();
  const auto key = std::make_pair(file, options);
  const auto found = programs_.find(key);
  if (found != programs_.end())
    return translated(info().name, file, [&] { return found->second; });
  return translated(info().name, file, [&] {
    cl::Program program(context_, kernelSource(file));
    build(program, file, options);
    // Moved: a copy that cannot be retained must not stay.
    return programs_.emplace(key, std::move(program)).first->second;
  });
}

void Context::build(const cl::Program& program, const std::string& file, const std::string& options) const
{
  // Not by cl::Program::build(), whose own error is lost where there is no log to be had.
  const Compilation compilation;
  const cl_device_id on = device()();
  const cl_int code = clBuildProgram(program(), 1, &on, options.c_str(), nullptr, nullptr);
  if (code == CL_SUCCESS)
    return;
  std::string log;
  try {
    log = program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device());
  } catch (const cl::Error&) {
    log = "none";
  }
  throw KernelBuildError({code, "clBuildProgram", file, info().name}, options, log);
}

} // namespace pcl_gpu_icp::opencl
