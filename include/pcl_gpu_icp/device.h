#pragma once

#include <pcl_gpu_icp/export.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace pcl_gpu_icp {

namespace opencl {
class Context;
struct DeviceHandle;
} // namespace opencl

/// What an OpenCL device reports of itself.
struct DeviceInfo {
  enum class Type { Gpu, Accelerator, Cpu, Other };

  std::string name;
  std::string platform;
  std::string driver;         ///< driver version as the vendor writes it
  std::string opencl_version; ///< e.g. "OpenCL 1.2 pocl ..."
  Type type = Type::Other;
  unsigned platform_index = 0; ///< position in the list of platforms, as in the selector "PLATFORM:DEVICE"
  unsigned device_index = 0;   ///< position among the platform's devices
  unsigned compute_units = 0;
  std::size_t max_work_group_size = 0; ///< work-items
  std::uint64_t global_memory = 0;     ///< bytes
  std::uint64_t max_allocation = 0;    ///< bytes in one buffer
  std::uint64_t local_memory = 0;      ///< bytes per work-group
  bool local_memory_is_global = false; ///< local memory is ordinary cached memory (CPUs, most embedded GPUs)
  bool unified_memory = false;         ///< shares memory with the host, so buffers are mapped and not copied
  bool fp64 = false;                   ///< double precision in kernels

  /// Work-items the device can hold at once: compute units times its largest work-group.
  std::size_t workItemsAtOnce() const { return std::size_t(compute_units) * max_work_group_size; }
};

PCL_GPU_ICP_API const char* toString(DeviceInfo::Type type);

/// A chosen OpenCL device. Cheap to copy; all copies and all aligners on it share one OpenCL context, which is
/// created on first use. Safe to use from several threads. Refused (DeviceError) in a child process after fork()
/// once the parent has used OpenCL, because OpenCL implementations do not survive fork().
class PCL_GPU_ICP_API Device {
public:
  /// Every device of every platform, in the order of the platforms.
  /// \throws DeviceError when no OpenCL implementation is installed
  static std::vector<Device> list();

  /// Selects a device.
  /// \param selector "gpu", "accelerator" or "cpu"; "PLATFORM:DEVICE" indices, e.g. "0:1"; or part of a device's
  ///        name, ignoring case. Empty: the environment variable PCL_GPU_ICP_DEVICE where it is set, otherwise the
  ///        first GPU, then accelerator, then CPU.
  /// \throws DeviceError when nothing matches; the message lists what is there
  static Device select(const std::string& selector = "");

  const DeviceInfo& info() const;

  /// Divides it into devices of so many compute units each, e.g. to keep some of a CPU's cores for other work.
  /// \throws DeviceError when it cannot be divided like that
  std::vector<Device> partition(unsigned compute_units) const;

private:
  friend class opencl::Context;
  explicit Device(std::shared_ptr<const opencl::DeviceHandle> handle);
  std::shared_ptr<const opencl::DeviceHandle> handle_;
};

/// Whether a thread of this process waits for kernels that OpenCL compiles, or fetches from where it keeps them. The
/// first start on a device takes some seconds of it, later ones hardly any.
PCL_GPU_ICP_API bool isCompilingKernels();

} // namespace pcl_gpu_icp
