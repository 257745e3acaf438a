#include "kernel_variants.h"

#include "device_handle.h"

#include <map>

namespace pcl_gpu_icp::opencl {

KernelVariants* KernelVariants::of(const DeviceInfo& device, const std::string& kernel, const cl::NDRange& local)
{
  if (!isPocl(device))
    return nullptr;
  std::string key = kernel;
  for (std::size_t i = 0; i < local.dimensions(); ++i)
    key += ' ' + std::to_string(local.get()[i]);
  static std::mutex mutex;
  static auto& variants = *new std::map<std::string, KernelVariants>; // outlives all queues
  const std::lock_guard<std::mutex> lock(mutex);
  return &variants[key];
}

bool KernelVariants::tryJoin(std::size_t width, bool has_offset)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (alone_ || width > width_ || (has_offset && !offset_))
    return false;
  ++in_flight_;
  return true;
}

void KernelVariants::leave()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  --in_flight_;
  changed_.notify_all();
}

void KernelVariants::beginAlone(std::size_t width, bool has_offset)
{
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return !alone_; });
  alone_ = true;
  changed_.wait(lock, [this] { return in_flight_ == 0; });
  width_ = width;
  offset_ = has_offset;
}

void KernelVariants::endAlone()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  alone_ = false;
  changed_.notify_all();
}

} // namespace pcl_gpu_icp::opencl
