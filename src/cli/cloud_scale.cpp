#include "cli/cloud_scale.h"

#include "report/format.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_gpu_icp::cli {

double CloudScale::spacing() const { return points > 0 ? extent / std::sqrt(static_cast<double>(points)) : 0; }

CloudScale scaleOf(const std::vector<std::array<double, 3>>& points)
{
  constexpr std::size_t most_looked_at = 4096;
  const std::size_t step = points.size() / most_looked_at + 1;
  CloudScale scale;
  scale.points = points.size();
  if (points.empty())
    return scale;
  std::vector<double> values;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (std::size_t i = 0; i < points.size(); i += step)
      values.push_back(points[i][axis]);
    const auto quantile = [&values](double fraction) {
      const auto place = values.begin() + static_cast<std::ptrdiff_t>(fraction * double(values.size() - 1));
      std::nth_element(values.begin(), place, values.end());
      return *place;
    };
    const double low = quantile(0.05);
    const double high = quantile(0.95);
    scale.extent = std::max(scale.extent, high - low);
    scale.magnitude = std::max({scale.magnitude, std::abs(low), std::abs(high)});
  }
  return scale;
}

std::optional<std::string> coarseCoordinates(const CloudScale& scale, const std::string& path)
{
  const auto largest = static_cast<float>(scale.magnitude);
  const double step = std::nextafter(largest, std::numeric_limits<float>::max()) - largest;
  constexpr double noticeable = 1.0 / 50;
  if (!(step > noticeable * scale.spacing()) || scale.extent == 0)
    return std::nullopt;
  return report::format("%s: its float coordinates near %.4g are %.2g apart, and its points about %.2g: digits are "
                        "lost; write them as double, or about a nearer origin",
                        path.c_str(),
                        scale.magnitude,
                        step,
                        scale.spacing());
}

std::optional<std::string> unlikeUnits(const CloudScale& source,
                                       const std::string& source_path,
                                       const CloudScale& target,
                                       const std::string& target_path)
{
  constexpr double most_alike = 300; // of millimetres and metres, of clouds that overlap in a third
  const auto [less, more] = std::minmax(source.extent, target.extent);
  if (less == 0 || more / less < most_alike)
    return std::nullopt;
  return report::format("%s spans %.4g and %s %.4g: are they in the same unit?",
                        source_path.c_str(),
                        source.extent,
                        target_path.c_str(),
                        target.extent);
}

std::optional<std::string> zeroReturns(const std::vector<std::array<double, 3>>& points, const std::string& path)
{
  const auto zeros = static_cast<std::size_t>(std::count(points.begin(), points.end(), std::array<double, 3>{}));
  constexpr std::size_t fewest = 5;
  constexpr std::size_t one_in = 100;
  if (zeros < fewest || zeros < points.size() / one_in)
    return std::nullopt;
  return report::format(
      "%s: %zu of %zu points are at exactly (0, 0, 0), where some sensors put what they did not see: left "
      "out; --drop-zero-returns=false keeps them",
      path.c_str(),
      zeros,
      points.size());
}

} // namespace pcl_gpu_icp::cli
