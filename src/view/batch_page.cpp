#include "view/batch_page.h"

#include <algorithm>

namespace pcl_gpu_icp::view {
namespace {

using report::Json;

/// What the table says of a pair.
/// \param result a line of the results
Json rowJson(const Json& result)
{
  Json row;
  for (const char* key : {"pair", "source", "target", "options", "status"})
    row[key] = result.at(key);
  if (result.contains("error")) {
    row["verdict"] = "failed";
    row["why"] = result.at("error").at("message");
    return row;
  }
  const Json& reasons = result.at("reasons");
  row["verdict"] = result.at("verdict");
  row["why"] = !result.at("why").is_null() ? result.at("why") : reasons.empty() ? Json() : reasons.front();
  for (const char* key : {"rmse", "iterations"})
    row[key] = result.at(key);
  const Json& quality = result.at("quality");
  row["near"] = quality.is_null() ? Json() : quality.at("source_near").at("after");
  row["time_ms"] = result.at("times_ms").value("total", Json());
  return row;
}

/// The worse is less.
std::pair<int, double> orderOf(const Json& row)
{
  constexpr const char* verdicts[] = {"failed", "wrong", "doubtful", "good"};
  const auto verdict = std::find(std::begin(verdicts), std::end(verdicts), row.at("verdict"));
  const auto near = row.find("near");
  return {static_cast<int>(verdict - std::begin(verdicts)),
          near == row.end() || near->is_null() ? 0 : near->get<double>()};
}

/// Removes rows from the end until the others fit in.
void cut(Json& rows, std::size_t most_bytes)
{
  std::size_t bytes = 0, count = 0;
  for (; count < rows.size() && bytes < most_bytes; ++count)
    bytes += report::dumpLine(rows[count]).size();
  rows.get_ref<Json::array_t&>().resize(count);
}

Json placesJson(const std::vector<RigidTransform>& trajectory)
{
  Json places = Json::array();
  for (const RigidTransform& pose : trajectory)
    places.push_back(pose.translation);
  return places;
}

} // namespace

std::string batchPage(const report::BatchReport& report,
                      std::string_view results,
                      const BatchGallery& gallery,
                      const std::vector<RigidTransform>& trajectory,
                      const Repetition& repetition)
{
  constexpr std::size_t most_row_bytes = 1200000;
  PageData data;
  const auto shown = gallery.entries();
  Json rows = Json::array(), pairs = Json::array();
  while (!results.empty()) {
    const std::size_t end = std::min(results.find('\n'), results.size() - 1);
    const Json result = Json::parse(results.substr(0, end));
    results.remove_prefix(end + 1);
    Json row = rowJson(result);
    const auto entry = shown.find(row.at("pair").get<std::size_t>());
    if (entry != shown.end()) {
      row["shown"] = pairs.size();
      pairs.push_back(data.pairJson(entry->second->view, result, entry->second->errors));
    }
    rows.push_back(std::move(row));
  }
  std::stable_sort(rows.begin(), rows.end(), [](const Json& a, const Json& b) { return orderOf(a) < orderOf(b); });
  cut(rows, most_row_bytes);

  Json settings = Json::object();
  for (const auto& [name, value] : report.options)
    settings["--" + name] = value;
  Json run;
  run["rows"] = std::move(rows);
  run["pairs"] = std::move(pairs);
  run["summary"] = Json::parse(toJson(report));
  run["trajectory"] = placesJson(trajectory);
  run["repeat"] = repeatJson(repetition, report.devices, settings);
  std::vector<std::string> scripts = pairScripts();
  scripts.insert(scripts.end(), {"jquery.min.js", "jquery.dataTables.min.js", "batch.js"});
  return pageOf({"pair.html", "batch.html"}, data, run, scripts);
}

} // namespace pcl_gpu_icp::view
