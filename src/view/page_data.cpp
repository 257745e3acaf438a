#include "view/page_data.h"

#include "view/histogram.h"

#include "report/alignment_times.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace pcl_gpu_icp::view {
namespace {

using report::Json;

/// Little-endian, in base64.
std::string base64(const std::vector<float>& numbers)
{
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(numbers.size() * 16 / 3 + 4);
  std::uint32_t bits = 0;
  int held = 0; // bits that wait for more
  const auto put = [&](std::uint32_t byte) {
    bits = bits << 8 | byte;
    for (held += 8; held >= 6; held -= 6)
      text += digits[bits >> (held - 6) & 63];
  };
  for (const float number : numbers) {
    std::uint32_t word;
    std::memcpy(&word, &number, sizeof word);
    for (int shift = 0; shift < 32; shift += 8)
      put(word >> shift & 0xff);
  }
  if (held > 0)
    text += digits[bits << (6 - held) & 63];
  text.append((4 - text.size() % 4) % 4, '=');
  return text;
}

Json cloudJson(const ShownCloud& cloud, const std::string& block)
{
  return {{"block", block}, {"shown", cloud.size()}, {"all", cloud.all}};
}

/// Around what all poses take.
Json boxJson(const PairView& view)
{
  Box box;
  for (const ShownPose& pose : view.poses) {
    const Box of_pose = frameOf(view, pose);
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::min(box.low[axis], of_pose.low[axis]);
      box.high[axis] = std::max(box.high[axis], of_pose.high[axis]);
    }
  }
  return {{"low", box.low}, {"high", box.high}};
}

Json histogramJson(const Histogram& histogram)
{
  return {{"edges", histogram.edges}, {"counts", histogram.counts}, {"medians", histogram.medians}};
}

} // namespace

std::string PageData::add(const std::vector<float>& numbers)
{
  std::string name = "block-" + std::to_string(count_++);
  blocks_ += "<script type=\"text/plain\" id=\"" + name + "\">" + base64(numbers) + "</script>\n";
  return name;
}

Json PageData::pairJson(const PairView& view, const Json& result, const std::vector<double>& errors)
{
  Json poses = Json::array();
  for (const ShownPose& pose : view.poses)
    poses.push_back(
        {{"name", pose.name}, {"matrix", report::matrixJson(pose.transform)}, {"block", add(pose.distances)}});
  Json wholes = Json::object();
  for (const auto& [what, milliseconds] : result.at("times_ms").items())
    wholes[what] = report::wholeOf(what);
  return {{"result", result},
          {"wholes", wholes},
          {"source", cloudJson(view.source, add(view.source.xyz))},
          {"target", cloudJson(view.target, add(view.target.xyz))},
          {"centre", view.target.centre},
          {"poses", poses},
          {"box", boxJson(view)},
          {"histogram", histogramJson(histogramOf(view))},
          {"errors", add({errors.begin(), errors.end()})}};
}

std::string PageData::html(const Json& run) const
{
  // A < in JSON is within a string; escaped, no text can end the element.
  std::string json;
  for (const char c : report::dumpLine(run))
    if (c == '<')
      json += "\\u003c";
    else
      json += c;
  return "<script type=\"application/json\" id=\"run\">" + json + "</script>\n" + blocks_;
}

} // namespace pcl_gpu_icp::view
