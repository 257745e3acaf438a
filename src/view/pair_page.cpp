#include "view/pair_page.h"

#include "report/alignment_json.h"
#include "report/comparison_json.h"
#include "report/format.h"

namespace pcl_gpu_icp::view {
namespace {

using report::Json;

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

/// A page for one pair.
/// \param last the script that fills it
/// \param run what that needs beside the pair
std::string pairPage(const std::string& last,
                     Json run,
                     const report::AlignmentReport& report,
                     const PairView& view,
                     const std::vector<double>& errors,
                     const Repetition& repetition)
{
  PageData data;
  run["pairs"] = {data.pairJson(view, alignmentJson(report), errors)};
  run["repeat"] = repeatJson(repetition, {report.result.device}, factsOf(report));
  std::vector<std::string> scripts = pairScripts();
  scripts.push_back(last);
  return pageOf({"pair.html"}, data, run, scripts);
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
