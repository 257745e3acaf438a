#include "device_cases.h"

#include <pcl_gpu_icp/error.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <limits>

namespace pcl_gpu_icp::test {

using opencl::Shape;
using opencl::Traits;

namespace {

bool isOwnMemory(const DeviceInfo& info, bool mapped) { return mapped == info.unified_memory; }

template <typename Wanted>
std::vector<DeviceCase> casesThat(const Wanted& wanted)
{
  std::vector<DeviceCase> cases;
  std::copy_if(deviceCases().begin(), deviceCases().end(), std::back_inserter(cases), wanted);
  return cases;
}

bool isKernelCase(const DeviceCase& device_case)
{
  return isOwnMemory(device_case.device.info(), device_case.traits.mapped_memory);
}

} // namespace

bool DeviceCase::searches() const { return device.info().platform != "rusticl" || traits.shape != Shape::Chunked; }

bool DeviceCase::isEmulated() const { return device.info().name.find("llvmpipe") != std::string::npos; }

bool DeviceCase::inPasses() const { return traits.max_work_items == 1; }

std::string DeviceCase::name() const
{
  const DeviceInfo& info = device.info();
  return "P" + std::to_string(info.platform_index) + "D" + std::to_string(info.device_index) +
         (traits.shape == Shape::Chunked ? "_Chunked" : "_Grouped") +
         (precision == Precision::Double ? "_Double" : "_Float") + (traits.mapped_memory ? "_Mapped" : "_Staged") +
         (inPasses() ? "_InPasses" : "");
}

std::size_t DeviceCase::mostPoints() const
{
  const std::size_t most = inPasses() ? 2'500 : isEmulated() ? 10'000 : 1'000'000;
  const char* limit = std::getenv("STAGES_TEST_MAX_POINTS");
  return limit ? std::min<std::size_t>(most, std::strtoull(limit, nullptr, 10)) : most;
}

std::vector<std::size_t> DeviceCase::sizes(std::size_t largest) const
{
  std::vector<std::size_t> sizes;
  for (const std::size_t n : {1, 2, 3, 127, 128, 129, 2047, 2048, 2049})
    if (n <= mostPoints())
      sizes.push_back(n);
  const std::size_t last = affordable(largest);
  if (last > sizes.back())
    sizes.push_back(last);
  return sizes;
}

double DeviceCase::epsilon() const
{
  return precision == Precision::Double ? std::numeric_limits<double>::epsilon()
                                        : std::numeric_limits<float>::epsilon();
}

const std::vector<DeviceCase>& deviceCases()
{
  static const std::vector<DeviceCase> cases = [] {
    std::vector<DeviceCase> result;
    std::vector<Device> devices;
    try {
      devices = Device::list();
    } catch (const DeviceError&) {
      // Devices.AtLeastOneIsThere asks again, where an exception fails a test.
    }
    for (const Device& device : devices)
      for (const Shape shape : {Shape::Chunked, Shape::Grouped})
        for (const Precision precision : {Precision::Float, Precision::Double})
          for (const bool mapped : {true, false}) {
            Traits traits = Traits::of(device.info());
            if (precision == Precision::Double && !traits.fp64)
              continue;
            traits.shape = shape;
            traits.mapped_memory = mapped;
            result.push_back({device, traits, precision});
            if (!isOwnMemory(device.info(), mapped))
              continue;
            traits.max_work_items = 1; // a work-group each
            result.push_back({device, traits, precision});
          }
    return result;
  }();
  return cases;
}

std::vector<DeviceCase> kernelCases() { return casesThat(isKernelCase); }

std::vector<DeviceCase> searchCases()
{
  return casesThat([](const DeviceCase& c) { return isKernelCase(c) && c.searches(); });
}

std::vector<DeviceCase> wholeCases()
{
  return casesThat([](const DeviceCase& c) { return isKernelCase(c) && !c.inPasses(); });
}

std::vector<DeviceCase> memoryCases()
{
  return casesThat([](const DeviceCase& c) {
    return c.traits.shape == Shape::Chunked && c.precision == Precision::Float && !c.inPasses();
  });
}

std::ostream& operator<<(std::ostream& stream, const DeviceCase& device_case)
{
  return stream << device_case.name() << " on " << device_case.device.info().name;
}

TEST(Devices, AtLeastOneIsThere)
{
  EXPECT_FALSE(Device::list().empty()) << "these tests claim nothing without an OpenCL device";
}

} // namespace pcl_gpu_icp::test
