#pragma once

#include "opencl/context.h"

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/result.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <ostream>
#include <string>
#include <vector>

namespace pcl_gpu_icp::test {

/// A device and one of the ways the kernels can be laid out on it.
struct DeviceCase {
  Device device;
  opencl::Traits traits;
  Precision precision = Precision::Float;

  /// Whether the search on the device can be relied on: Mesa 22.3 miscompiles the chunked one, which Traits::of never
  /// chooses there.
  bool searches() const;

  /// Whether a CPU plays a GPU, which takes milliseconds for a launch.
  bool isEmulated() const;

  /// Whether every launch of more than one work-group runs in several passes.
  bool inPasses() const;

  /// Letters, digits and underscores, e.g. "P0D0_Chunked_Float_Mapped" or "P0D0_Grouped_Double_Staged_InPasses".
  std::string name() const;

  /// The largest number of points to spend on this case: devices that interpret or emulate are slow, and so are many
  /// passes. The environment variable STAGES_TEST_MAX_POINTS lowers it, for running under oclgrind.
  std::size_t mostPoints() const;

  /// n points, or as many as to spend.
  std::size_t affordable(std::size_t n) const { return std::min(n, mostPoints()); }

  /// 1, 2, 3, work-group and block sizes with their neighbours, and `largest`: those within mostPoints().
  std::vector<std::size_t> sizes(std::size_t largest = 100'000) const;

  /// Spacing of the numbers that the device sums in, relative to 1.
  double epsilon() const;
};

/// Every OpenCL device x kernel shape x precision that the device has x mapped and staged memory, and in passes in the
/// device's own memory.
/// Empty when there is none, which Devices.AtLeastOneIsThere reports as a failure.
const std::vector<DeviceCase>& deviceCases();

/// Those of them in the device's own memory, for what depends on the kernels only.
std::vector<DeviceCase> kernelCases();

/// Those of them whose search can be relied on.
std::vector<DeviceCase> searchCases();

/// Those of them that launch whole.
std::vector<DeviceCase> wholeCases();

/// Those of them that differ in device and memory only, for what does not depend on the kernels.
std::vector<DeviceCase> memoryCases();

std::ostream& operator<<(std::ostream& stream, const DeviceCase& device_case);

class OnDevice : public testing::TestWithParam<DeviceCase> {};

template <typename Case>
std::string nameOf(const testing::TestParamInfo<Case>& info)
{
  return info.param.name();
}

} // namespace pcl_gpu_icp::test

#define RUN_WITH_EVERY_KERNEL(Suite)                                                                                   \
  INSTANTIATE_TEST_SUITE_P(, Suite, testing::ValuesIn(kernelCases()), nameOf<DeviceCase>)

#define RUN_WITH_EVERY_SEARCH(Suite)                                                                                   \
  INSTANTIATE_TEST_SUITE_P(, Suite, testing::ValuesIn(searchCases()), nameOf<DeviceCase>)

#define RUN_WITH_EVERY_MEMORY(Suite)                                                                                   \
  INSTANTIATE_TEST_SUITE_P(, Suite, testing::ValuesIn(memoryCases()), nameOf<DeviceCase>)
