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

std::string wholeOf(const std::string& what)
{
  constexpr const char* outer[] = {"read", "device", "guess", "overlap", "align", "fitness"};
  if (what == "total")
    return "";
  if (what.rfind("device_", 0) == 0)
    return "search";
  return std::find(std::begin(outer), std::end(outer), what) != std::end(outer) ? "total" : "align";
}

std::string timesText(const AlignmentReport& report)
{
  std::string text;
  for (const auto& [what, milliseconds] : timesOf(report))
    if (what == "total")
      text.insert(0, format("%.1f ms: ", milliseconds));
    else if (wholeOf(what) == "total")
      text += (text.empty() ? "" : ", ") + format("%s %.1f", what.c_str(), milliseconds);
  return text + "\n";
}

namespace {

std::string partsText(const Times& times, const std::string& whole, int indent)
{
  std::string text;
  for (const auto& [what, milliseconds] : times)
    if (wholeOf(what) == whole) {
      text += format("%*s%-*s %10.1f ms\n", indent, "", 39 - indent, what.c_str(), milliseconds);
      text += partsText(times, what, indent + 2);
    }
  return text;
}

} // namespace

std::string nestedTimesText(const AlignmentReport& report)
{
  constexpr int margin = 11; // where the values of a summary stand
  return partsText(timesOf(report), "", margin).substr(margin);
}

} // namespace pcl_gpu_icp::report
