#pragma once

#include "report/matrix.h"

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/version.h>

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace pcl_gpu_icp::report {

using Json = nlohmann::ordered_json;

/// Indented, with a line break at the end. NaN and infinities, which JSON does not have, become null.
inline std::string dump(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

/// On one line, with its line break.
inline std::string dumpLine(const Json& json)
{
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// What each document begins with.
/// \param arguments of the command, and before them its name
inline Json documentOf(const std::vector<std::string>& arguments)
{
  return {{"version", PCL_GPU_ICP_VERSION}, {"arguments", arguments}};
}

/// The device as every report names it.
inline Json deviceJson(const DeviceInfo& device)
{
  return {
      {"name", device.name}, {"platform", device.platform}, {"driver", device.driver}, {"type", toString(device.type)}};
}

inline Json matrixJson(const RigidTransform& transform) { return Json(toMatrix(transform)); }

} // namespace pcl_gpu_icp::report
