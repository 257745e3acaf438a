// Device: what is listed and what a selector selects.
#include "scoped_directory.h"
#include "scoped_environment.h"

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <sys/wait.h>

namespace pcl_gpu_icp::test {

namespace {

std::string position(const Device& device)
{
  return std::to_string(device.info().platform_index) + ":" + std::to_string(device.info().device_index);
}

std::string messageOf(const std::string& selector)
{
  try {
    Device::select(selector);
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "no DeviceError";
}

struct Outcome {
  int exit_code;
  std::string output;
};

/// Runs device_probe with the given assignments before it.
Outcome probe(const std::string& environment)
{
  Outcome outcome{-1, ""};
  FILE* pipe = popen((environment + " '" DEVICE_PROBE "' 2>&1").c_str(), "r");
  if (!pipe)
    return outcome;
  std::array<char, 256> piece{};
  while (std::fgets(piece.data(), piece.size(), pipe))
    outcome.output += piece.data();
  const int status = pclose(pipe);
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

} // namespace

TEST(DeviceList, ReportsWhatTheKernelsAreAdaptedTo)
{
  for (const Device& device : Device::list()) {
    const DeviceInfo& info = device.info();
    SCOPED_TRACE(info.name);
    EXPECT_FALSE(info.name.empty());
    EXPECT_FALSE(info.platform.empty());
    EXPECT_FALSE(info.driver.empty());
    EXPECT_EQ(info.opencl_version.rfind("OpenCL ", 0), 0U);
    EXPECT_GE(info.compute_units, 1U);
    EXPECT_GE(info.max_work_group_size, 27U);
    EXPECT_GE(info.global_memory, info.max_allocation);
    EXPECT_GE(info.max_allocation, 1U << 20);
    EXPECT_GE(info.local_memory, 1U << 10);
    EXPECT_EQ(info.workItemsAtOnce(), info.compute_units * info.max_work_group_size);
  }
}

TEST(DeviceList, KeepsItsOrder)
{
  const auto first = Device::list(), second = Device::list();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i)
    EXPECT_EQ(position(first[i]), position(second[i]));
}

TEST(DeviceSelect, TakesAPosition)
{
  for (const Device& device : Device::list())
    EXPECT_EQ(position(Device::select(position(device))), position(device));
}

TEST(DeviceSelect, TakesAType)
{
  const auto devices = Device::list();
  for (const auto type : {DeviceInfo::Type::Gpu, DeviceInfo::Type::Accelerator, DeviceInfo::Type::Cpu}) {
    const auto first =
        std::find_if(devices.begin(), devices.end(), [&](const Device& device) { return device.info().type == type; });
    if (first == devices.end())
      EXPECT_THROW(Device::select(toString(type)), DeviceError);
    else
      EXPECT_EQ(position(Device::select(toString(type))), position(*first));
  }
}

TEST(DeviceSelect, TakesPartOfANameIgnoringCase)
{
  for (const Device& device : Device::list()) {
    const std::string& name = device.info().name;
    std::string part = name.substr(name.size() / 4, name.size() / 2);
    std::string upper = part, lower = part;
    std::transform(part.begin(), part.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
    std::transform(part.begin(), part.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
    for (const std::string& selector : {name, part, upper, lower})
      EXPECT_NE(Device::select(selector).info().name.find(part), std::string::npos) << selector;
  }
}

TEST(DeviceSelect, TypesIgnoreCaseToo)
{
  const std::string type = toString(Device::list().front().info().type);
  std::string upper = type;
  std::transform(type.begin(), type.end(), upper.begin(), [](unsigned char c) { return std::toupper(c); });
  EXPECT_EQ(position(Device::select(upper)), position(Device::select(type)));
}

TEST(DeviceSelect, PrefersGpuThenAcceleratorThenCpu)
{
  unsetenv("PCL_GPU_ICP_DEVICE");
  const DeviceInfo::Type chosen = Device::select().info().type;
  for (const Device& device : Device::list())
    EXPECT_LE(chosen, device.info().type) << device.info().name;
}

TEST(DeviceSelect, ReadsTheEnvironmentOnlyWhenNotTold)
{
  const auto devices = Device::list();
  for (const Device& device : devices) {
    const ScopedEnvironment environment("PCL_GPU_ICP_DEVICE", position(device));
    EXPECT_EQ(position(Device::select()), position(device));
    EXPECT_EQ(position(Device::select(position(devices.back()))), position(devices.back()));
  }
}

TEST(DeviceSelect, AnEmptyEnvironmentVariableIsAsGoodAsNone)
{
  const ScopedEnvironment environment("PCL_GPU_ICP_DEVICE", "");
  EXPECT_NO_THROW(Device::select());
}

TEST(DeviceSelect, SaysWhatThereIsWhenNothingMatches)
{
  const std::string message = messageOf("No Such Device");
  EXPECT_NE(message.find("No Such Device"), std::string::npos) << message;
  for (const Device& device : Device::list()) {
    EXPECT_NE(message.find(device.info().name), std::string::npos) << message;
    EXPECT_NE(message.find(position(device)), std::string::npos) << message;
  }
  EXPECT_NE(messageOf("99:0").find("99:0"), std::string::npos);
}

TEST(DeviceSelect, NamesTheEnvironmentVariableThatMatchesNothing)
{
  const ScopedEnvironment environment("PCL_GPU_ICP_DEVICE", "no such device");
  EXPECT_NE(messageOf("").find("PCL_GPU_ICP_DEVICE"), std::string::npos) << messageOf("");
}

TEST(DeviceProbe, FindsADeviceInAProcessOfItsOwn)
{
  const Outcome outcome = probe("");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
}

TEST(DeviceProbe, SaysWhatToInstallWhereThereIsNoOpenCL)
{
  const ScopedDirectory no_vendors;
  const Outcome outcome = probe("OCL_ICD_VENDORS='" + no_vendors.path() + "'");
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_NE(outcome.output.find("no OpenCL implementation is installed"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("pocl-opencl-icd"), std::string::npos) << outcome.output;
}

} // namespace pcl_gpu_icp::test
