#include "queue.h"

#include "compilation.h"
#include "device_handle.h"
#include "gate.h"

#include <algorithm>
#include <utility>

namespace pcl_gpu_icp::opencl {

namespace {

// Events are read in batches, so that an endless stream of launches does not pile them up.
constexpr std::size_t max_pending_events = 1024;

// Room for a cloud that grows a little from one scan to the next; small clouds of all sizes have the same.
std::uint64_t roomy(std::size_t bytes)
{
  constexpr std::size_t smallest = 256 << 10;
  return std::max(bytes + bytes / 8, smallest);
}

double milliseconds(const cl::Event& event)
{
  const auto start = event.getProfilingInfo<CL_PROFILING_COMMAND_START>();
  const auto end = event.getProfilingInfo<CL_PROFILING_COMMAND_END>();
  return end > start ? static_cast<double>(end - start) * 1e-6 : 0.0;
}

std::size_t widthOf(const WorkSize& size)
{
  return *std::max_element(size.global.get(), size.global.get() + size.global.dimensions());
}

bool hasOffset(const cl::NDRange& offset)
{
  return std::any_of(offset.get(), offset.get() + offset.dimensions(), [](std::size_t o) { return o != 0; });
}

} // namespace

Queue::Queue(const Device& device, const Traits& traits, std::string build_options)
: context_(&Context::of(device))
, traits_(traits)
, build_options_(std::move(build_options))
, queue_(translated(device.info().name, "", [&] {
  const auto gate = enterGate();
  return cl::CommandQueue(context_->handle(), context_->device(), CL_QUEUE_PROFILING_ENABLE);
}))
{
}

Queue::~Queue()
{
  if (usedBeforeFork())
    return;
  try {
    queue_.finish();
    if (staging_memory_)
      queue_.enqueueUnmapMemObject(staging_.buffer_, staging_memory_);
    queue_.finish();
  } catch (const cl::Error&) {
    // The device is gone; its memory with it.
  }
  settle();
}

void Queue::setShare(std::shared_ptr<DeviceShare> share)
{
  if (grant_ != 0)
    finish();
  share_ = std::move(share);
}

void Queue::reserve(Buffer& buffer, std::size_t bytes)
{
  if (bytes <= buffer.capacity_)
    return;
  if (bytes > traits_.max_allocation) {
    abandon();
    throw DeviceError({CL_MEM_OBJECT_ALLOCATION_FAILURE, "clCreateBuffer", "", info().name},
                      "the " + buffer.what_ + " need " + std::to_string(bytes) + " bytes, the device allows " +
                          std::to_string(traits_.max_allocation) +
                          " in one buffer; downsample the clouds or choose another device");
  }
  guarded("", [&] {
    const std::size_t capacity = std::min(roomy(bytes), traits_.max_allocation);
    buffer.buffer_ = cl::Buffer();
    allocated_ -= std::exchange(buffer.capacity_, 0);
    const cl_mem_flags placement = traits_.mapped_memory ? CL_MEM_ALLOC_HOST_PTR : 0;
    buffer.buffer_ = cl::Buffer(context_->handle(), CL_MEM_READ_WRITE | placement, capacity);
    allocated_ += buffer.capacity_ = capacity;
  });
}

void* Queue::pinned(std::size_t bytes)
{
  if (bytes > staging_.capacity_) {
    const std::size_t capacity = roomy(bytes);
    guarded("", [&] {
      if (staging_memory_)
        queue_.enqueueUnmapMemObject(staging_.buffer_, staging_memory_);
      staging_memory_ = nullptr;
      staging_.capacity_ = 0;
      queue_.finish();
      staging_.buffer_ = cl::Buffer(context_->handle(), CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, capacity);
      staging_memory_ = queue_.enqueueMapBuffer(staging_.buffer_, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, capacity);
      staging_.capacity_ = capacity;
    });
  }
  return staging_memory_;
}

void Queue::upload(Buffer& buffer, std::size_t bytes, const std::function<void(void*)>& fill)
{
  if (bytes == 0)
    return;
  refuseAfterFork();
  reserve(buffer, bytes);
  guarded("", [&] {
    cl::Event event;
    if (traits_.mapped_memory) {
      void* memory = queue_.enqueueMapBuffer(buffer.buffer_, CL_TRUE, CL_MAP_WRITE_INVALIDATE_REGION, 0, bytes);
      settle();
      try {
        fill(memory);
      } catch (...) {
        queue_.enqueueUnmapMemObject(buffer.buffer_, memory);
        throw;
      }
      queue_.enqueueUnmapMemObject(buffer.buffer_, memory, nullptr, &event);
    }
    else {
      // Blocking, because the staging memory is filled again by the next upload.
      void* memory = pinned(bytes);
      fill(memory);
      queue_.enqueueWriteBuffer(buffer.buffer_, CL_TRUE, 0, bytes, memory, nullptr, &event);
      settle();
    }
    pending_.emplace_back("upload", std::move(event));
  });
}

void Queue::download(const Buffer& buffer, std::size_t bytes, const std::function<void(const void*)>& use)
{
  if (bytes == 0)
    return;
  refuseAfterFork();
  guarded("", [&] {
    cl::Event event;
    if (traits_.mapped_memory) {
      void* memory = queue_.enqueueMapBuffer(buffer.buffer_, CL_TRUE, CL_MAP_READ, 0, bytes, nullptr, &event);
      settle();
      try {
        use(memory);
      } catch (...) {
        queue_.enqueueUnmapMemObject(buffer.buffer_, memory);
        throw;
      }
      queue_.enqueueUnmapMemObject(buffer.buffer_, memory);
    }
    else {
      void* memory = pinned(bytes);
      queue_.enqueueReadBuffer(buffer.buffer_, CL_TRUE, 0, bytes, memory, nullptr, &event);
      settle();
      use(memory);
    }
    pending_.emplace_back("download", std::move(event));
  });
  if (pending_.size() > max_pending_events)
    account();
}

void Queue::finish()
{
  refuseAfterFork();
  guarded("", [&] { queue_.finish(); });
  settle();
}

Profile Queue::takeProfile()
{
  account();
  return std::exchange(profile_, {});
}

void Queue::account()
{
  finish();
  settled_ = std::exchange(pending_, {});
  guarded("", [&] {
    for (const auto& [stage, event] : settled_)
      profile_.add(stage, milliseconds(event));
  });
}

Queue::Kernel& Queue::kernelObject(const KernelName& name)
{
  refuseAfterFork();
  Kernel& kernel = kernels_[name.file + "/" + name.name];
  if (!kernel.handle()) {
    const cl::Program program = context_->program(name.file, build_options_);
    guarded(name.name, [&] {
      kernel.handle = cl::Kernel(program, name.name.c_str());
      kernel.name = name.file + ' ' + name.name + ' ' + build_options_;
      kernel.at_once =
          info().compute_units * kernel.handle.getWorkGroupInfo<CL_KERNEL_WORK_GROUP_SIZE>(context_->device());
    });
  }
  return kernel;
}

void Queue::enqueue(const char* stage, const KernelName& name, Kernel& kernel, const WorkSize& size)
{
  const auto part = [&](const WorkSize& part_size, const cl::NDRange& offset) {
    KernelVariants* variants = KernelVariants::of(info(), kernel.name, size.local);
    guarded(name.name, [&] {
      if (variants && !variants->tryJoin(widthOf(part_size), hasOffset(offset)))
        enqueueAlone(*variants, stage, kernel, part_size, offset);
      else {
        if (variants)
          joined_.push_back(variants);
        enqueuePart(stage, kernel, part_size, offset);
      }
    });
  };
  // Passes are cut along the first dimension, in whole work-groups.
  const std::size_t items = size.global.get()[0], group = size.local.get()[0];
  const std::size_t rows = size.global.dimensions() > 1 ? size.global.get()[1] : 1;
  const std::size_t shared = share_ ? std::min(share_->capacity(), kernel.at_once) : items * rows;
  const std::size_t at_once = std::min(shared, traits_.max_work_items) / rows;
  const std::size_t step = std::max(at_once / group, std::size_t(1)) * group;
  for (std::size_t first = 0; first < items; first += step) {
    const std::size_t some = std::min(step, items - first);
    if (share_) {
      if (first > 0)
        finish();
      obtain(stage, some * rows);
    }
    if (rows == 1)
      part({cl::NDRange(some), size.local}, cl::NDRange(first));
    else
      part({cl::NDRange(some, rows), size.local}, cl::NDRange(first, 0));
  }
}

void Queue::enqueuePart(const char* stage, Kernel& kernel, const WorkSize& size, const cl::NDRange& offset)
{
  cl::Event event;
  queue_.enqueueNDRangeKernel(kernel.handle, offset, size.global, size.local, nullptr, &event);
  pending_.emplace_back(stage, std::move(event));
}

void Queue::enqueueAlone(
    KernelVariants& variants, const char* stage, Kernel& kernel, const WorkSize& size, const cl::NDRange& offset)
{
  // Who waits for others to finish must not keep them waiting.
  queue_.finish();
  leaveVariants();
  variants.beginAlone(widthOf(size), hasOffset(offset));
  try {
    enqueuePart(stage, kernel, size, offset);
    const Compilation compilation(pending_.back().second);
    queue_.finish();
  } catch (...) {
    variants.endAlone();
    throw;
  }
  variants.endAlone();
}

void Queue::obtain(const char* stage, std::size_t work_items)
{
  // What another launch still runs on is not given away.
  if (grant_ != 0 && work_items != granted_) {
    guarded("", [&] { queue_.finish(); });
    leaveVariants();
  }
  if (work_items > granted_)
    giveBack();
  if (grant_ != 0)
    share_->narrow(grant_, stage, work_items);
  else
    grant_ = share_->request(stage, work_items);
  granted_ = work_items;
}

void Queue::abandon() noexcept
{
  try {
    queue_.finish();
  } catch (const cl::Error&) {
    // Then nothing of it runs any more.
  }
  settle();
}

void Queue::settle() noexcept
{
  leaveVariants();
  giveBack();
}

void Queue::leaveVariants() noexcept
{
  for (KernelVariants* variants : joined_)
    variants->leave();
  joined_.clear();
}

void Queue::giveBack() noexcept
{
  granted_ = 0;
  if (grant_ != 0)
    share_->release(std::exchange(grant_, 0));
}

} // namespace pcl_gpu_icp::opencl
