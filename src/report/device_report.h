#pragma once

#include <pcl_gpu_icp/device.h>

#include <string>
#include <vector>

namespace pcl_gpu_icp::report {

/// \param chosen the device that an alignment would run on; nullptr when the selection matches none
std::string toText(const std::vector<DeviceInfo>& devices, const DeviceInfo* chosen);
std::string toJson(const std::vector<DeviceInfo>& devices, const DeviceInfo* chosen);

} // namespace pcl_gpu_icp::report
