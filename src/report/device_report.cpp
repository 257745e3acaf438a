#include "report/device_report.h"

#include "report/format.h"
#include "report/json.h"

namespace pcl_gpu_icp::report {
namespace {

constexpr double mebibyte = 1024.0 * 1024.0;

std::string selector(const DeviceInfo& device) { return format("%u:%u", device.platform_index, device.device_index); }

bool same(const DeviceInfo& device, const DeviceInfo* other)
{
  return other && device.platform_index == other->platform_index && device.device_index == other->device_index;
}

} // namespace

std::string toText(const std::vector<DeviceInfo>& devices, const DeviceInfo* chosen)
{
  std::string text;
  for (const DeviceInfo& device : devices) {
    text += selector(device) + "  " + device.name + (same(device, chosen) ? "  [chosen]\n" : "\n");
    text += "     type           " + std::string(toString(device.type)) + "\n";
    text += "     platform       " + device.platform + "\n";
    text += "     driver         " + device.driver + " (" + device.opencl_version + ")\n";
    text += format("     compute units  %u, %zu work-items at once\n", device.compute_units, device.workItemsAtOnce());
    text += format("     memory         %.0f MiB%s, at most %.0f MiB in one buffer\n",
                   device.global_memory / mebibyte,
                   device.unified_memory ? " shared with the host" : "",
                   device.max_allocation / mebibyte);
    text += std::string("     fp64           ") + (device.fp64 ? "yes\n" : "no\n");
  }
  return text;
}

std::string toJson(const std::vector<DeviceInfo>& devices, const DeviceInfo* chosen)
{
  Json list = Json::array();
  for (const DeviceInfo& device : devices) {
    Json entry = deviceJson(device);
    entry["selector"] = selector(device);
    entry["opencl_version"] = device.opencl_version;
    entry["compute_units"] = device.compute_units;
    entry["max_work_group_size"] = device.max_work_group_size;
    entry["work_items_at_once"] = device.workItemsAtOnce();
    entry["global_memory_bytes"] = device.global_memory;
    entry["max_allocation_bytes"] = device.max_allocation;
    entry["local_memory_bytes"] = device.local_memory;
    entry["unified_memory"] = device.unified_memory;
    entry["fp64"] = device.fp64;
    entry["chosen"] = same(device, chosen);
    list.push_back(entry);
  }
  Json json;
  json["devices"] = list;
  json["chosen"] = chosen ? Json(selector(*chosen)) : Json();
  return dump(json);
}

} // namespace pcl_gpu_icp::report
