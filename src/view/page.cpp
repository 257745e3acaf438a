#include "view/page.h"

#include "embedded_page.h"
#include "view/page_data.h"

#include "report/alignment_json.h"
#include "report/comparison_json.h"
#include "report/format.h"

#include <ctime>
#include <stdexcept>

namespace pcl_gpu_icp::view {
namespace {

using report::Json;

std::string embedded(const std::string& name)
{
  for (const EmbeddedFile& file : embedded_files)
    if (name == file.name)
      return file.text;
  throw std::logic_error("no file " + name + " is embedded");
}

std::string scripts(const std::vector<std::string>& names)
{
  std::string html;
  for (const std::string& name : names)
    html += "<script>\n" + embedded(name) + "\n</script>\n";
  return html;
}

/// The skeleton of a page, its {{places}} filled.
std::string page(const std::string& templates, const std::string& data, const std::string& scripts)
{
  std::string html = embedded("page.html");
  const auto fill = [&html](const std::string& place, const std::string& content) {
    const std::string mark = "{{" + place + "}}";
    html.replace(html.find(mark), mark.size(), content);
  };
  // From the end on, so that no mark is looked for in what was filled in.
  fill("scripts", scripts);
  fill("data", data);
  fill("templates", templates);
  fill("style", embedded("page.css"));
  return html;
}

std::string now()
{
  const std::time_t time = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&time, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &utc);
  return text;
}

std::string deviceText(const DeviceInfo& device)
{
  return device.name + " (" + toString(device.type) + ", " + device.platform + ", driver " + device.driver + ")";
}

/// What is to be known of the run beside its command line.
Json factsOf(const report::AlignmentReport& report)
{
  const AlignmentResult& result = report.result;
  Json facts;
  facts["metric"] = toString(result.metric);
  facts["loss"] = result.loss.weighs()
                      ? report::format("%s, scale %.6g", toString(result.loss.function), result.loss_scale)
                      : "none";
  facts["motions"] = toString(result.motions);
  facts["search"] = report::format("%s, %u threads", toString(result.search), result.threads);
  facts["pipeline"] = report::format("%s, %s precision", toString(result.pipeline), toString(result.precision));
  facts["iterations allowed"] = std::to_string(report.iteration_limit);
  facts["maximum distance"] = report.max_distance ? report::format("%g", *report.max_distance) : "none";
  return facts;
}

Json repeatJson(const Repetition& repetition, const DeviceInfo& device, const Json& settings)
{
  Json facts = settings;
  facts["device"] = deviceText(device);
  facts["versions"] = repetition.versions;
  facts["directory"] = repetition.directory;
  facts["made"] = now();
  return {{"command", repetition.command}, {"facts", facts}};
}

double nearOf(const AlignmentResult& result) { return result.quality ? 3 * result.quality->spacing : 0; }

std::vector<std::string> withPair(const std::string& last)
{
  return {"three.min.js", "OrbitControls.js", "chart.min.js", "page.js", "scene.js", "charts.js", "pair.js", last};
}

/// A page for one pair.
/// \param last the script that fills it
/// \param run what that needs beside the pair
std::string pairPage(const char* last,
                     Json run,
                     const report::AlignmentReport& report,
                     const PairView& view,
                     const std::vector<double>& errors,
                     const Repetition& repetition)
{
  PageData data;
  run["pairs"] = {data.pairJson(view, alignmentJson(report), nearOf(report.result), errors)};
  run["repeat"] = repeatJson(repetition, report.result.device, factsOf(report));
  return page(embedded("pair.html"), data.html(run), scripts(withPair(last)));
}

} // namespace

std::string alignmentPage(const report::AlignmentReport& report,
                          const PairView& view,
                          const std::vector<double>& errors,
                          const Repetition& repetition)
{
  return pairPage("align.js", {}, report, view, errors, repetition);
}

std::string comparisonPage(const report::ComparisonReport& report,
                           const report::AlignmentReport& ours,
                           const PairView& view,
                           const std::vector<double>& errors,
                           const Repetition& repetition)
{
  return pairPage("compare.js", {{"comparison", comparisonJson(report)}}, ours, view, errors, repetition);
}

} // namespace pcl_gpu_icp::view
