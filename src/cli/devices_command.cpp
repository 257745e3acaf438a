#include "cli/commands.h"
#include "cli/help.h"
#include "cli/interruption.h"
#include "cli/output_file.h"

#include "report/device_report.h"

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/error.h>

#include <memory>
#include <optional>

namespace pcl_gpu_icp::cli {
namespace {

ExitCode listDevices(bool json)
{
  std::vector<DeviceInfo> devices;
  for (const Device& device : Device::list())
    devices.push_back(device.info());
  std::optional<DeviceInfo> chosen;
  std::exception_ptr nothing_chosen;
  try {
    chosen = Device::select().info();
  } catch (const DeviceError&) {
    nothing_chosen = std::current_exception();
  }
  const DeviceInfo* choice = chosen ? &*chosen : nullptr;
  writeToStandardOutput(json ? report::toJson(devices, choice) : report::toText(devices, choice));
  if (nothing_chosen)
    std::rethrow_exception(nothing_chosen);
  return ExitCode::Success;
}

} // namespace

Run addDevices(CLI::App& command)
{
  const auto json = std::make_shared<bool>(false);
  command.add_flag("--json", *json, "print JSON")->group(group::output);
  command.footer(exampleText({{"What there is", "pcl_gpu_icp devices"},
                              {"For a script", "pcl_gpu_icp devices --json"},
                              {"What a choice comes to", "PCL_GPU_ICP_DEVICE=cpu pcl_gpu_icp devices"}}));
  return [json] {
    const Interruption interruption(endAtOnce);
    return listDevices(*json);
  };
}

} // namespace pcl_gpu_icp::cli
