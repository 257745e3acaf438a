#include "report/alignment_times.h"

#include "report/format.h"

#include <algorithm>
#include <iterator>
#include <utility>

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

namespace {

/// 0 for the total, 1 for what it is made of, 2 for parts of an alignment.
int depthOf(const std::string& what)
{
  if (what == "total")
    return 0;
  constexpr const char* outer[] = {"read", "device", "guess", "overlap", "align", "fitness"};
  return std::find(std::begin(outer), std::end(outer), what) != std::end(outer) ? 1 : 2;
}

std::string lineOf(const Times::value_type& time)
{
  const int indent = 2 * depthOf(time.first);
  return format("%*s%-*s %10.1f ms\n", 11 + indent, "", 28 - indent, time.first.c_str(), time.second);
}

} // namespace

std::string timesText(const AlignmentReport& report)
{
  std::string text;
  for (const auto& [what, milliseconds] : timesOf(report))
    if (depthOf(what) == 1)
      text += (text.empty() ? "" : ", ") + format("%s %.1f", what.c_str(), milliseconds);
    else if (depthOf(what) == 0)
      text.insert(0, format("%.1f ms: ", milliseconds));
  return text + "\n";
}

std::string nestedTimesText(const AlignmentReport& report)
{
  std::string outer, parts, total;
  for (const auto& time : timesOf(report)) {
    std::string& text = depthOf(time.first) == 0 ? total : depthOf(time.first) == 1 ? outer : parts;
    text += lineOf(time);
    if (time.first == "align")
      outer += std::exchange(parts, "");
  }
  return total.substr(11) + outer + parts;
}

} // namespace pcl_gpu_icp::report
