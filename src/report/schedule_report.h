#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/schedule.h>

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_gpu_icp::report {

/// What a trace says of a pair.
struct TracedPair {
  std::size_t number = 0;
  std::string source;
  std::string target;
};

/// A schedule in the Trace Event Format, which Perfetto and chrome://tracing show: a process for each device, a thread
/// for each of its lanes, a colour for each pair, and counters of what is idle and what waits.
/// \param pairs by the numbers that the schedule has
std::string
toTrace(const Schedule& schedule, const std::vector<DeviceInfo>& devices, const std::vector<TracedPair>& pairs);

} // namespace pcl_gpu_icp::report
