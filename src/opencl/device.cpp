#include <pcl_gpu_icp/device.h>

#include "device_handle.h"
#include "error.h"
#include "gate.h"
#include "kernel_cache.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cstdlib>
#include <optional>
#include <unistd.h>

namespace pcl_gpu_icp {

namespace opencl {

namespace {

std::atomic<pid_t> user{0}; ///< the process that used OpenCL first

} // namespace

bool usedBeforeFork() noexcept
{
  const pid_t first = user;
  return first != 0 && first != getpid();
}

void refuseAfterFork()
{
  pid_t nobody = 0;
  user.compare_exchange_strong(nobody, getpid());
  if (usedBeforeFork())
    throw DeviceError({},
                      "OpenCL was used before fork() and does not work in the child process; fork first, or align in "
                      "the parent, or exec() a new program");
}

} // namespace opencl

namespace {

using Type = DeviceInfo::Type;

constexpr const char* install_advice =
    "no OpenCL implementation is installed; for the CPU: apt install pocl-opencl-icd; for a GPU: its vendor's OpenCL "
    "driver (intel-opencl-icd, nvidia-opencl-icd, mesa-opencl-icd, ROCm). If one is installed, check that "
    "OCL_ICD_VENDORS points to it";

Type typeOf(cl_device_type type)
{
  if (type & CL_DEVICE_TYPE_GPU)
    return Type::Gpu;
  if (type & CL_DEVICE_TYPE_ACCELERATOR)
    return Type::Accelerator;
  if (type & CL_DEVICE_TYPE_CPU)
    return Type::Cpu;
  return Type::Other;
}

DeviceInfo describe(const cl::Platform& platform, unsigned platform_index, const cl::Device& device, unsigned index)
{
  DeviceInfo info;
  info.name = device.getInfo<CL_DEVICE_NAME>();
  info.platform = platform.getInfo<CL_PLATFORM_NAME>();
  info.driver = device.getInfo<CL_DRIVER_VERSION>();
  info.opencl_version = device.getInfo<CL_DEVICE_VERSION>();
  info.type = typeOf(device.getInfo<CL_DEVICE_TYPE>());
  info.platform_index = platform_index;
  info.device_index = index;
  info.compute_units = device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>();
  info.max_work_group_size = device.getInfo<CL_DEVICE_MAX_WORK_GROUP_SIZE>();
  info.global_memory = device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>();
  info.max_allocation = device.getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>();
  info.local_memory = device.getInfo<CL_DEVICE_LOCAL_MEM_SIZE>();
  info.local_memory_is_global = device.getInfo<CL_DEVICE_LOCAL_MEM_TYPE>() == CL_GLOBAL;
  info.unified_memory = device.getInfo<CL_DEVICE_HOST_UNIFIED_MEMORY>() != 0;
  info.fp64 = device.getInfo<CL_DEVICE_EXTENSIONS>().find("cl_khr_fp64") != std::string::npos;
  return info;
}

std::vector<cl::Platform> platforms()
{
  opencl::kernelCache(); // before PoCL looks for it
  constexpr int platform_not_found_khr = -1001;
  std::vector<cl::Platform> found;
  try {
    cl::Platform::get(&found);
  } catch (const cl::Error& error) {
    if (error.err() != platform_not_found_khr)
      throw DeviceError({error.err(), opencl::callName(error.what()), "", ""}, "");
  }
  if (found.empty())
    throw DeviceError({platform_not_found_khr, "clGetPlatformIDs", "", ""}, install_advice);
  return found;
}

std::string lowered(std::string text)
{
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::optional<Type> typeNamed(const std::string& selector)
{
  for (const Type type : {Type::Gpu, Type::Accelerator, Type::Cpu})
    if (selector == toString(type))
      return type;
  return std::nullopt;
}

/// What may keep PoCL, without which there is often no other device, from having one.
std::string noDeviceAdvice()
{
  const opencl::KernelCache& cache = opencl::kernelCache();
  if (!cache.obstacle.empty())
    return cache.obstacle;
  return "OpenCL is installed but no platform has a device; for the CPU: apt install pocl-opencl-icd; where it is "
         "installed, see that " +
         cache.directory + " can be made";
}

bool matches(const DeviceInfo& info, const std::string& selector)
{
  if (const auto type = typeNamed(selector))
    return info.type == *type;
  if (selector == std::to_string(info.platform_index) + ":" + std::to_string(info.device_index))
    return true;
  return lowered(info.name).find(selector) != std::string::npos;
}

std::string listing(const std::vector<Device>& devices)
{
  std::string text;
  for (const Device& device : devices) {
    const DeviceInfo& info = device.info();
    text += (text.empty() ? "" : ", ") + std::to_string(info.platform_index) + ":" + std::to_string(info.device_index) +
            " " + info.name + " (" + toString(info.type) + ")";
  }
  return text;
}

} // namespace

const char* toString(DeviceInfo::Type type)
{
  switch (type) {
  case Type::Gpu:
    return "gpu";
  case Type::Accelerator:
    return "accelerator";
  case Type::Cpu:
    return "cpu";
  case Type::Other:
    break;
  }
  return "other";
}

Device::Device(std::shared_ptr<const opencl::DeviceHandle> handle)
: handle_(std::move(handle))
{
}

const DeviceInfo& Device::info() const { return handle_->info; }

std::vector<Device> Device::partition(unsigned compute_units) const
{
  const auto gate = opencl::enterGate();
  const cl_device_partition_property equally[] = {
      CL_DEVICE_PARTITION_EQUALLY, static_cast<cl_device_partition_property>(compute_units), 0};
  return opencl::translated(info().name, "", [&] {
    std::vector<cl::Device> parts;
    cl::Device(handle_->device).createSubDevices(equally, &parts);
    const cl::Platform platform(handle_->device.getInfo<CL_DEVICE_PLATFORM>());
    std::vector<Device> devices;
    for (const cl::Device& part : parts) {
      const DeviceInfo described = describe(platform, info().platform_index, part, info().device_index);
      devices.push_back(Device(std::make_shared<opencl::DeviceHandle>(opencl::DeviceHandle{described, part})));
    }
    return devices;
  });
}

std::vector<Device> Device::list()
{
  const auto gate = opencl::enterGate();
  std::vector<Device> devices;
  const auto all_platforms = platforms();
  for (unsigned p = 0; p < all_platforms.size(); ++p) {
    std::vector<cl::Device> found;
    try {
      all_platforms[p].getDevices(CL_DEVICE_TYPE_ALL, &found);
    } catch (const cl::Error& error) {
      if (error.err() != CL_DEVICE_NOT_FOUND)
        throw DeviceError({error.err(), opencl::callName(error.what()), "", ""}, "");
    }
    for (unsigned d = 0; d < found.size(); ++d) {
      devices.push_back(opencl::translated("", "", [&] {
        const DeviceInfo info = describe(all_platforms[p], p, found[d], d);
        return Device(std::make_shared<opencl::DeviceHandle>(opencl::DeviceHandle{info, found[d]}));
      }));
    }
  }
  return devices;
}

Device Device::select(const std::string& selector)
{
  const char* environment = std::getenv("PCL_GPU_ICP_DEVICE");
  const bool from_environment = selector.empty() && environment && *environment;
  const std::string asked = from_environment ? environment : selector;
  const std::string wanted = lowered(asked);

  const std::vector<Device> devices = list();
  if (devices.empty())
    throw DeviceError({CL_DEVICE_NOT_FOUND, "clGetDeviceIDs", "", ""}, noDeviceAdvice());

  const auto choose = [&](const std::string& pattern) {
    return std::find_if(
        devices.begin(), devices.end(), [&](const Device& device) { return matches(device.info(), pattern); });
  };
  if (!wanted.empty()) {
    const auto chosen = choose(wanted);
    if (chosen == devices.end())
      throw DeviceError({},
                        "no OpenCL device matches \"" + asked + "\"" +
                            (from_environment ? " (from PCL_GPU_ICP_DEVICE)" : "") + "; there is: " + listing(devices));
    return *chosen;
  }
  for (const Type type : {Type::Gpu, Type::Accelerator, Type::Cpu}) {
    const auto chosen = choose(toString(type));
    if (chosen != devices.end())
      return *chosen;
  }
  return devices.front();
}

} // namespace pcl_gpu_icp
