#pragma once

#include <pcl_gpu_icp/error.h>

#include <cstddef>
#include <cstdint>

namespace pcl_gpu_icp {

/// Thrown out of an operation that its owner cancelled.
class PCL_GPU_ICP_API Cancelled : public Error {
public:
  using Error::Error;
};

/// A device that several use at once: asked before each operation for the work-items it needs. Used by one thread.
class PCL_GPU_ICP_API DeviceShare {
public:
  /// Names what was granted; 0 names nothing.
  using Grant = std::uint64_t;

  virtual ~DeviceShare() = default;

  /// Work-items that the device holds at once. An operation that needs more is run in passes.
  virtual std::size_t capacity() const = 0;

  /// Waits until the device has so many idle work-items, at most capacity(), for an operation.
  /// \throws Cancelled
  virtual Grant request(const char* operation, std::size_t work_items) = 0;

  /// Gives back all but so many, or none: the operation that follows needs no more.
  virtual void narrow(Grant grant, const char* operation, std::size_t work_items) = 0;

  /// Gives back what is left.
  virtual void release(Grant grant) noexcept = 0;
};

} // namespace pcl_gpu_icp
