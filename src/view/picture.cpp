#include "view/picture.h"

#include "view/canvas.h"
#include "view/histogram.h"
#include "view/projection.h"
#include "view/text.h"

#include "report/ending.h"
#include "report/format.h"
#include "report/judgement.h"

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp::view {
namespace {

using report::format;
using Anchor = Canvas::Anchor;
using Font = Canvas::Font;

constexpr int width = 1600, margin = 44;
constexpr double inner = width - 2 * margin;
constexpr Colour ink = 0x1b1f24, muted = 0x59636e, rule = 0xd1d5da, ground = 0xf6f8fa;
constexpr Colour before_colour = 0x8c959f, after_colour = 0x00795a;

Colour colourOf(Verdict verdict)
{
  switch (verdict) {
  case Verdict::Good:
    return 0x00795a;
  case Verdict::Doubtful:
    return 0x9a6700;
  case Verdict::Wrong:
    return 0xb3261e;
  }
  return ink;
}

std::string numbersText(const report::AlignmentReport& report)
{
  const AlignmentResult& result = report.result;
  std::string text;
  if (result.inliers > 0)
    text += format("RMSE %.4g → %.4g   ·   ", result.rmse_before, result.rmse);
  if (result.quality)
    text += format("near the target %.0f %% → %.0f %% of the source's points   ·   ",
                   100 * result.quality->before.source,
                   100 * result.quality->after.source);
  return text + report::counted(static_cast<std::size_t>(result.iterations), "iteration");
}

/// What the verdict rests on, then what to try.
std::vector<std::string> explanations(const report::AlignmentReport& report)
{
  std::vector<std::string> texts = judgementOf(report).reasons;
  for (const std::string& advice : adviceFor(report))
    texts.push_back("try: " + advice);
  return texts;
}

/// \return where the next part starts
int drawTitle(Canvas& canvas, const report::AlignmentReport& report, int y)
{
  const Verdict verdict = judgementOf(report).verdict;
  const Font chip{24, 0xffffff, true}, title{30, ink, true}, numbers{20, ink}, small{18, muted};
  const double chip_width = canvas.widthOf(toString(verdict), chip) + 44;
  canvas.pill(margin, y, chip_width, 44, colourOf(verdict));
  canvas.text(margin + chip_width / 2, y + 31, toString(verdict), chip, Anchor::Middle);
  const double left = margin + chip_width + 20;
  const std::string files = fileNameOf(report.source) + " onto " + fileNameOf(report.target);
  canvas.text(left, y + 33, canvas.shortened(files, width - margin - left, title), title);
  y += 80;
  canvas.text(margin, y, canvas.shortened(numbersText(report), inner, numbers), numbers);
  constexpr std::size_t most_lines = 4;
  std::vector<std::string> lines;
  for (const std::string& text : explanations(report))
    for (const std::string& line : canvas.wrapped(lineOf(text), inner, small))
      lines.push_back(line);
  lines.resize(std::min(lines.size(), most_lines));
  for (const std::string& line : lines)
    canvas.text(margin, y += 27, line, small);
  return y + 22;
}

/// A length of one digit that takes up to a fifth of a panel.
/// \param right,y its end
void drawScale(Canvas& canvas, double right, double y, double scale)
{
  const double wanted = width / 15.0 / scale;
  const double decade = std::pow(10, std::floor(std::log10(wanted)));
  const double length = decade * (wanted >= 5 * decade ? 5 : wanted >= 2 * decade ? 2 : 1);
  const double left = right - length * scale;
  canvas.line(left, y, right, y, 2, ink);
  for (const double end : {left, right})
    canvas.line(end, y - 5, end, y + 5, 2, ink);
  canvas.text(left - 10, y + 6, format("%g", length), {16, ink}, Anchor::Right);
}

void drawLegend(Canvas& canvas, int y)
{
  double right = width - margin;
  const std::pair<const char*, Colour> entries[] = {
      {"both", both_colour}, {"target", target_colour}, {"source", source_colour}};
  for (const auto& [name, colour] : entries) {
    const Font font{18, ink};
    canvas.text(right, y, name, font, Anchor::Right);
    right -= canvas.widthOf(name, font) + 24;
    canvas.pill(right, y - 13, 15, 15, colour);
    right -= 22;
  }
}

int drawPose(Canvas& canvas, const PairView& view, const ShownPose& pose, const std::string& heading, int y)
{
  constexpr int gap = 20, height = 334, caption = 34;
  constexpr int panel_width = (width - 2 * margin - 2 * gap) / 3;
  canvas.text(margin, y + 20, heading, {20, ink, true});
  y += 34;
  const Box box = frameOf(view, pose);
  int x = margin;
  for (const Direction& direction : directions) {
    canvas.fill(x, y, panel_width, height, ground);
    const double scale = project(canvas, {x, y + caption, panel_width, height - caption}, view, pose, box, direction);
    drawScale(canvas, x + panel_width - 14, y + 20, scale);
    constexpr const char* axes[] = {"x", "y", "z"};
    canvas.text(x + 14,
                y + 26,
                format("%s: %s →  %s ↑", direction.name, axes[direction.right], axes[direction.up]),
                {16, muted});
    canvas.frame(x, y, panel_width, height, rule);
    x += panel_width + gap;
  }
  return y + height + 18;
}

/// Round numbers from the first edge to the last.
std::vector<double> ticks(const Histogram& histogram)
{
  constexpr double many = 3; // decades, of which each has one tick
  const double first = histogram.edges.front(), last = histogram.edges.back();
  std::vector<double> values;
  for (int decade = static_cast<int>(std::floor(std::log10(first))); std::pow(10, decade) <= last; ++decade)
    for (const int digit : {1, 2, 5})
      if (digit == 1 || std::log10(last / first) < many)
        values.push_back(digit * std::pow(10, decade));
  values.erase(
      std::remove_if(values.begin(), values.end(), [=](double value) { return value < first || value > last; }),
      values.end());
  return values;
}

/// \param bottom of the picture, down to which it reaches
void drawHistogram(Canvas& canvas, const PairView& view, const std::optional<Quality>& quality, int y, int bottom)
{
  const int height = bottom - y - 120;
  const Histogram histogram = histogramOf(view);
  const std::pair<const char*, Colour> poses[] = {{"before", before_colour}, {"after", after_colour}};
  canvas.text(margin, y + 20, "Distance of the source's points to the target", {20, ink, true});
  double right = width - margin;
  for (const int pose : {1, 0}) {
    const Font font{18, ink};
    const std::string entry = format("%s, median %.3g", poses[pose].first, histogram.medians[pose]);
    canvas.text(right, y + 20, entry, font, Anchor::Right);
    right -= canvas.widthOf(entry, font) + 24;
    canvas.pill(right, y + 7, 15, 15, poses[pose].second);
    right -= 22;
  }
  y += 40;
  const double base = y + height;
  const double low = std::log(histogram.edges.front()), high = std::log(histogram.edges.back());
  const auto across = [&](double distance) { return margin + inner * (std::log(distance) - low) / (high - low); };
  std::size_t most = 1;
  for (const auto& counts : histogram.counts)
    most = std::max(most, *std::max_element(counts.begin(), counts.end()));
  for (const double value : ticks(histogram)) {
    canvas.line(across(value), y, across(value), base + 6, 1, rule);
    canvas.text(across(value), base + 26, format("%g", value), {16, muted}, Anchor::Middle);
  }
  for (const int pose : {0, 1}) {
    std::vector<std::pair<double, double>> outline;
    const auto& counts = histogram.counts[pose];
    for (std::size_t bin = 0; bin < counts.size(); ++bin)
      for (const double edge : {histogram.edges[bin], histogram.edges[bin + 1]})
        outline.emplace_back(across(edge),
                             base - (height - 8) * static_cast<double>(counts[bin]) / static_cast<double>(most));
    canvas.area(outline, base, poses[pose].second, 0.3);
  }
  canvas.line(margin, base, width - margin, base, 1, muted);
  const double near = quality ? 3 * quality->spacing : 0;
  if (near > histogram.edges.front() && near < histogram.edges.back()) {
    const bool on_the_left = across(near) > width / 2.0;
    canvas.dashes(across(near), y, across(near), base, ink);
    canvas.text(across(near) + (on_the_left ? -8 : 8),
                y + 16,
                format("near: three spacings, %.3g", near),
                {16, ink},
                on_the_left ? Anchor::Right : Anchor::Left);
  }
  canvas.text(margin, base + 52, "in the unit of the files, on a logarithmic scale", {16, muted});
  const auto shown = [](const char* role, const ShownCloud& cloud) {
    return cloud.size() == cloud.all ? format("all %zu points of the %s", cloud.all, role)
                                     : format("%zu of %zu points of the %s", cloud.size(), cloud.all, role);
  };
  canvas.text(width - margin,
              base + 52,
              "shown: " + shown("source", view.source) + ", " + shown("target", view.target),
              {16, muted},
              Anchor::Right);
}

} // namespace

std::string pictureOf(const report::AlignmentReport& report, const PairView& view)
{
  constexpr int height = 1300;
  Canvas canvas(width, height, 0xffffff);
  int y = drawTitle(canvas, report, 36);
  drawLegend(canvas, y + 20);
  y = drawPose(canvas, view, view.poses[0], "Before", y);
  y = drawPose(canvas, view, view.poses[1], "After", y);
  drawHistogram(canvas, view, report.result.quality, y, height);
  return canvas.png();
}

} // namespace pcl_gpu_icp::view
