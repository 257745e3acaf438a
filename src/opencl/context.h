#pragma once

#include "cl.h"

#include <pcl_gpu_icp/device.h>

#include <limits>
#include <map>
#include <string>

namespace pcl_gpu_icp::opencl {

/// How a kernel is laid out over the device.
enum class Shape {
  Chunked, ///< few work-items, each a contiguous chunk in wide vectors, no barriers: CPUs
  Grouped, ///< a work-item per point, reductions in local memory: GPUs
};

/// What the kernels are adapted to. Taken from the device; tests replace single values.
struct Traits {
  Shape shape = Shape::Grouped;
  bool mapped_memory = false; ///< buffers are mapped; otherwise staged through pinned memory
  bool fp64 = false;
  std::size_t work_group_size = 128; ///< of the Grouped shape; a power of two
  std::uint64_t max_allocation = 0;  ///< bytes
  /// A launch of more work-items runs in passes, each of one work-group at least.
  std::size_t max_work_items = std::numeric_limits<std::size_t>::max();

  static Traits of(const DeviceInfo& info);
};

/// The OpenCL context of one device and the programs built in it. One per device and process, created on first use
/// and never released: OpenCL implementations are gone by the time static objects are destroyed. Thread-safe.
class Context {
public:
  static Context& of(const Device& device);

  const DeviceInfo& info() const { return device_.info(); }
  const cl::Context& handle() const { return context_; }
  const cl::Device& device() const;

  /// The program made of one kernel file, built at most once for each set of options.
  /// \throws KernelBuildError
  cl::Program program(const std::string& file, const std::string& options);

private:
  explicit Context(const Device& device);
  void build(const cl::Program& program, const std::string& file, const std::string& options) const;

  Device device_;
  cl::Context context_;
  std::map<std::pair<std::string, std::string>, cl::Program> programs_;
};

} // namespace pcl_gpu_icp::opencl
