#include "report/alignment_times.h"

namespace pcl_gpu_icp::report {

Times timesOf(const AlignmentReport& report)
{
  Times times;
  const auto add = [&times](const StageTimes& from, const char* what, const char* as) {
    const auto found = from.find(what);
    if (found != from.end())
      times.emplace_back(as, found->second.milliseconds);
  };
  add(report.command_times, "read", "read");
  add(report.command_times, "device", "device");
  add(report.command_times, "guess", "guess");
  add(report.command_times, "overlap", "overlap");
  for (const char* step : {"start", "tree", "normals", "pack", "search", "estimate", "quality"})
    add(report.result.host_times, step, step);
  for (const auto& [what, time] : report.result.device_times)
    times.emplace_back("device_" + what, time.milliseconds);
  add(report.result.host_times, "total", "align");
  add(report.command_times, "fitness", "fitness");
  add(report.command_times, "total", "total");
  return times;
}

} // namespace pcl_gpu_icp::report
