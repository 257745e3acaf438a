#pragma once

#include "cl.h"
#include "context.h"
#include "error.h"
#include "kernel_variants.h"
#include "profile.h"

#include <pcl_gpu_icp/device_share.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace pcl_gpu_icp::opencl {

/// A buffer on the device that grows as needed and keeps its memory. Its content is lost when it grows.
class Buffer {
public:
  /// \param what names the content in errors, e.g. "point pairs"
  explicit Buffer(std::string what)
  : what_(std::move(what))
  {
  }

  const cl::Buffer& handle() const { return buffer_; }
  std::size_t capacity() const { return capacity_; }

private:
  friend class Queue;
  std::string what_;
  std::size_t capacity_ = 0; ///< bytes
  cl::Buffer buffer_;
};

/// Where a kernel is found.
struct KernelName {
  std::string file;
  std::string name;
};

/// Global and local work sizes of a launch.
struct WorkSize {
  cl::NDRange global;
  cl::NDRange local;
};

/// An in-order queue with the kernel objects launched on it and the times they took. Used by one thread at a time;
/// queues of several threads share the device's Context.
class Queue {
public:
  /// \param build_options options that every kernel of this queue is compiled with
  Queue(const Device& device, const Traits& traits, std::string build_options);
  ~Queue();
  Queue(const Queue&) = delete;
  Queue& operator=(const Queue&) = delete;

  /// Every launch asks `share` for its work-items, and what it has been granted goes back when the device is known to
  /// have finished. A launch of fewer work-items than the one before gives back the others. null: it asks nobody.
  void setShare(std::shared_ptr<DeviceShare> share);

  const DeviceInfo& info() const { return context_->info(); }
  const Traits& traits() const { return traits_; }

  /// Makes room for `bytes`.
  /// \throws DeviceError with both numbers when the device allows no buffer that large
  void reserve(Buffer& buffer, std::size_t bytes);

  /// Lets `fill` write the first `bytes` of a buffer: straight into it where memory is shared with the host, through
  /// pinned memory elsewhere.
  void upload(Buffer& buffer, std::size_t bytes, const std::function<void(void*)>& fill);

  /// Waits for all that was enqueued, then lets `use` read the first `bytes` of a buffer.
  void download(const Buffer& buffer, std::size_t bytes, const std::function<void(const void*)>& use);

  /// Enqueues a kernel; `stage` is what its time is accounted to.
  template <typename... Arguments>
  void launch(const char* stage, const KernelName& kernel, const WorkSize& size, const Arguments&... arguments)
  {
    Kernel& object = kernelObject(kernel);
    guarded(kernel.name, [&] {
      cl_uint index = 0;
      (setArgument(object.handle, index++, arguments), ...);
    });
    enqueue(stage, kernel, object, size);
  }

  void finish();

  /// Bytes of the buffers that were made room for here.
  std::size_t allocated() const { return allocated_; }

  /// Waits for all that was enqueued and returns the times since the last call.
  Profile takeProfile();

private:
  static void setArgument(cl::Kernel& kernel, cl_uint index, const Buffer& buffer)
  {
    kernel.setArg(index, buffer.handle());
  }
  template <typename Value>
  static void setArgument(cl::Kernel& kernel, cl_uint index, const Value& value)
  {
    kernel.setArg(index, value);
  }

  struct Kernel {
    cl::Kernel handle;
    std::string name;        ///< with its file and build options
    std::size_t at_once = 0; ///< work-items that the device holds of it
  };

  Kernel& kernelObject(const KernelName& kernel);
  void enqueue(const char* stage, const KernelName& name, Kernel& kernel, const WorkSize& size);
  void enqueuePart(const char* stage, Kernel& kernel, const WorkSize& size, const cl::NDRange& offset);
  void enqueueAlone(
      KernelVariants& variants, const char* stage, Kernel& kernel, const WorkSize& size, const cl::NDRange& offset);
  void obtain(const char* stage, std::size_t work_items);
  /// Runs `call` as translated() does. Where it fails, nobody waits for what was enqueued here.
  template <typename Call>
  auto guarded(const std::string& kernel, Call&& call) -> decltype(call())
  {
    try {
      return translated(info().name, kernel, std::forward<Call>(call));
    } catch (...) {
      abandon();
      throw;
    }
  }
  void abandon() noexcept;
  /// The device has finished what was enqueued here.
  void settle() noexcept;
  void leaveVariants() noexcept;
  void giveBack() noexcept;
  void* pinned(std::size_t bytes);
  void account();

  Context* context_;
  Traits traits_;
  std::string build_options_;
  cl::CommandQueue queue_;
  std::map<std::string, Kernel> kernels_;
  std::shared_ptr<DeviceShare> share_;
  DeviceShare::Grant grant_ = 0;        ///< of share_; 0: none
  std::size_t granted_ = 0;             ///< work-items
  std::vector<KernelVariants*> joined_; ///< of the launches that may still run
  std::size_t allocated_ = 0;
  Buffer staging_{"staging memory"};
  void* staging_memory_ = nullptr;
  std::vector<std::pair<const char*, cl::Event>> pending_;
  /// Of the last account. Released one account later: PoCL 6 unlocks an event after clFinish has returned.
  std::vector<std::pair<const char*, cl::Event>> settled_;
  Profile profile_;
};

} // namespace pcl_gpu_icp::opencl
