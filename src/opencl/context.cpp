#include "context.h"

#include "device_handle.h"
#include "error.h"
#include "kernel_cache.h"
#include "kernel_source.h"

#include <algorithm>
#include <cstdlib>

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
  refuseAfterFork();
  static std::mutex mutex;
  static auto& contexts = *new std::map<cl_device_id, Context*>;
  const std::lock_guard<std::mutex> lock(mutex);
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
  const std::lock_guard<std::mutex> lock(programs_mutex_);
  const auto key = std::make_pair(file, options);
  const auto found = programs_.find(key);
  if (found != programs_.end())
    return found->second;
  cl::Program program = translated(info().name, file, [&] { return cl::Program(context_, kernelSource(file)); });
  try {
    program.build(device(), options.c_str());
  } catch (const cl::BuildError& error) {
    std::string log;
    for (const auto& entry : error.getBuildLog())
      log += entry.second;
    throw KernelBuildError({error.err(), error.what(), file, info().name}, options, log);
  } catch (const cl::Error& error) {
    throw KernelBuildError({error.err(), error.what(), file, info().name}, options, "");
  }
  return programs_[key] = program;
}

} // namespace pcl_gpu_icp::opencl
