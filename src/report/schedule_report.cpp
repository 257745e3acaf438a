#include "report/schedule_report.h"

#include "report/json.h"

#include <array>
#include <set>
#include <utility>

namespace pcl_gpu_icp::report {
namespace {

/// Names that trace viewers have a colour for.
constexpr std::array<const char*, 12> colours{"thread_state_running",
                                              "rail_response",
                                              "thread_state_iowait",
                                              "rail_animation",
                                              "rail_idle",
                                              "good",
                                              "thread_state_runnable",
                                              "rail_load",
                                              "olive",
                                              "cq_build_passed",
                                              "yellow",
                                              "generic_work"};

constexpr double microseconds_per_millisecond = 1000;

class Events {
public:
  void add(const Json& event)
  {
    text_ += (text_.empty() ? "" : ",\n") + event.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  std::string file() const { return "{\"displayTimeUnit\": \"ms\", \"traceEvents\": [\n" + text_ + "\n]}\n"; }

private:
  std::string text_;
};

Json nameOf(const char* what, std::size_t process, std::size_t thread, const std::string& name)
{
  return {{"ph", "M"}, {"name", what}, {"pid", process}, {"tid", thread}, {"args", {{"name", name}}}};
}

Json counter(const Schedule::Level& level, const char* name, const char* unit, std::size_t value)
{
  return {{"ph", "C"},
          {"name", name},
          {"pid", level.device},
          {"tid", 0},
          {"ts", level.at_ms * microseconds_per_millisecond},
          {"args", {{unit, value}}}};
}

} // namespace

std::string
toTrace(const Schedule& schedule, const std::vector<DeviceInfo>& devices, const std::vector<TracedPair>& pairs)
{
  const auto spans = schedule.spans();
  Events events;
  for (std::size_t device = 0; device < devices.size(); ++device)
    events.add(nameOf("process_name", device, 0, devices[device].name));
  std::set<std::pair<std::size_t, std::size_t>> lanes;
  for (const Schedule::Span& span : spans)
    if (lanes.emplace(span.device, span.lane).second)
      events.add(nameOf("thread_name", span.device, span.lane, "lane " + std::to_string(span.lane)));

  for (const Schedule::Span& span : spans) {
    const TracedPair& pair = pairs.at(span.pair);
    const bool whole = span.what == "pair";
    events.add(
        {{"ph", "X"},
         {"name", whole ? "pair " + std::to_string(pair.number) : span.what},
         {"cat", whole ? "pair" : "stage"},
         {"pid", span.device},
         {"tid", span.lane},
         {"ts", span.begin_ms * microseconds_per_millisecond},
         {"dur", (span.end_ms - span.begin_ms) * microseconds_per_millisecond},
         {"cname", colours[pair.number % colours.size()]},
         {"args",
          {{"pair", pair.number}, {"source", pair.source}, {"target", pair.target}, {"work_items", span.work_items}}}});
  }
  for (const Schedule::Level& level : schedule.levels()) {
    events.add(counter(level, "idle work-items", "work-items", level.idle));
    events.add(counter(level, "waiting requests", "requests", level.waiting));
  }
  return events.file();
}

} // namespace pcl_gpu_icp::report
