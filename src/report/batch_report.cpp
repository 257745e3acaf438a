#include "report/batch_report.h"

#include "report/format.h"
#include "report/judgement.h"
#include "report/progress.h"

#include <algorithm>

namespace pcl_gpu_icp::report {
namespace {

constexpr std::size_t most_listed = 10;

Json orDefault(std::size_t value) { return value > 0 ? Json(value) : Json(); }

Json worstJson(const BatchReport& report)
{
  Json list = Json::array();
  for (const auto& [identity, outcome] : report.worst)
    list.push_back({{"pair", identity.pair},
                    {"source", identity.source},
                    {"target", identity.target},
                    {"verdict", toString(outcome.judgement.verdict)},
                    {"reasons", outcome.judgement.reasons}});
  return list;
}

Json unsuccessfulJson(const BatchReport& report)
{
  Json list = Json::array();
  for (const auto& [identity, outcome] : report.unsuccessful)
    list.push_back({{"pair", identity.pair},
                    {"source", identity.source},
                    {"target", identity.target},
                    {"status", toString(outcome.status)},
                    {"why", outcome.why}});
  return list;
}

Json trajectoryJson(const TrajectoryReport& trajectory)
{
  Json json{{"files", trajectory.files}, {"scans", trajectory.scans}, {"poses", trajectory.poses}};
  const auto end = trajectory.ends_before_pair;
  json["ends_before_pair"] = end ? Json(*end) : Json();
  return json;
}

} // namespace

std::size_t BatchReport::count(PairStatus status) const
{
  return static_cast<std::size_t>(std::count_if(
      unsuccessful.begin(), unsuccessful.end(), [status](const auto& pair) { return pair.outcome.status == status; }));
}

std::size_t BatchReport::gotWorse() const
{
  return static_cast<std::size_t>(
      std::count_if(unsuccessful.begin(), unsuccessful.end(), [](const auto& pair) { return pair.outcome.got_worse; }));
}

std::optional<double> BatchReport::pairsPerSecond() const
{
  return aligned > 0 && wall_s > 0 ? std::optional(static_cast<double>(aligned) / wall_s) : std::nullopt;
}

std::string toText(const BatchReport& report)
{
  std::string text = format("pairs      %zu: %zu converged, ", report.pairs, report.converged);
  if (report.at_limit > 0)
    text += format("%zu at the limit, ", report.at_limit);
  text += format("%zu without an answer", report.notConverged());
  if (report.gotWorse() > 0)
    text += format(" (%zu got worse)", report.gotWorse());
  text += format(", %zu failed", report.failed());
  if (report.left() > 0)
    text += format(", %zu left", report.left());
  text += report.kept > 0 ? format(" (%zu were there already)\n", report.kept) : "\n";
  text += format("verdicts   %zu good, %zu doubtful, %zu wrong\n", report.good, report.doubtful, report.wrong);
  for (const DeviceInfo& device : report.devices)
    text += "device     " + device.name + " (" + toString(device.type) + ", " + device.platform + ")\n";
  text += format("time       %.2f s", report.wall_s);
  if (const auto rate = report.pairsPerSecond())
    text += format(", %.1f pairs/s", *rate);
  text += "\nresults    " + report.results + "\n";
  if (report.trajectory) {
    for (const std::string& file : report.trajectory->files)
      text += "trajectory " + file + "\n";
    text += format("poses      %zu of %zu scans", report.trajectory->poses, report.trajectory->scans);
    if (const auto end = report.trajectory->ends_before_pair)
      text += format(": pair %zu has no transform", *end);
    text += "\n";
  }
  for (const auto& [identity, outcome] : report.worst)
    text += format("pair %-5zu ", identity.pair) + identity.source + " onto " + identity.target + ": " +
            judgementText(outcome.judgement) + "\n";
  for (std::size_t i = 0; i < std::min(report.unsuccessful.size(), most_listed); ++i) {
    const auto& [identity, outcome] = report.unsuccessful[i];
    text += format("pair %-5zu ", identity.pair) + identity.source + " onto " + identity.target + ": " +
            outcomeText(outcome) + "\n";
  }
  if (report.unsuccessful.size() > most_listed)
    text += format("and %zu more\n", report.unsuccessful.size() - most_listed);
  return text;
}

std::string toJson(const BatchReport& report)
{
  Json json = documentOf(report.arguments);
  json["complete"] = report.left() == 0;
  json["pairs"] = report.pairs;
  json["converged"] = report.converged;
  json["at_the_limit"] = report.at_limit;
  json["not_converged"] = report.notConverged();
  json["got_worse"] = report.gotWorse();
  json["failed"] = report.failed();
  json["left"] = report.left();
  json["kept"] = report.kept;
  json["aligned"] = report.aligned;
  json["shard"] = report.shard ? Json{{"number", report.shard->number}, {"of", report.shard->of}} : Json();
  json["verdicts"] = {{"good", report.good}, {"doubtful", report.doubtful}, {"wrong", report.wrong}};
  json["worst"] = worstJson(report);
  json["unsuccessful"] = unsuccessfulJson(report);
  json["wall_s"] = report.wall_s;
  const auto rate = report.pairsPerSecond();
  json["pairs_per_second"] = rate ? Json(*rate) : Json();
  json["results"] = report.results;
  json["trajectory"] = report.trajectory ? trajectoryJson(*report.trajectory) : Json();
  json["devices"] = Json::array();
  for (const DeviceInfo& device : report.devices)
    json["devices"].push_back(deviceJson(device));
  json["settings"] = {{"policy", toString(report.policy)},
                      {"pairs_in_flight", orDefault(report.pairs_in_flight)},
                      {"points_in_flight", orDefault(report.points_in_flight)},
                      {"capacity", orDefault(report.capacity)},
                      {"options", report.options}};
  return dump(json);
}

} // namespace pcl_gpu_icp::report
