#include "view/histogram.h"

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp::view {

Histogram histogramOf(const PairView& view)
{
  constexpr std::size_t bins = 60;
  constexpr double outside = 0.005; // the share that may lie beyond the edges on either side
  constexpr double widest = 1e4;    // the last edge over the first
  std::vector<float> all;
  for (const ShownPose& pose : view.poses)
    all.insert(all.end(), pose.distances.begin(), pose.distances.end());
  all.erase(std::remove(all.begin(), all.end(), 0.0F), all.end()); // as in clouds of rounded coordinates
  if (all.empty())
    all.push_back(1);
  std::sort(all.begin(), all.end());
  const auto at = [&all](double share) {
    return static_cast<double>(all[static_cast<std::size_t>(share * static_cast<double>(all.size() - 1))]);
  };
  const double last = at(1 - outside);
  const double first = std::max(std::min(at(outside), last / 10), last / widest);

  Histogram histogram;
  const double step = std::log(last / first) / bins;
  for (std::size_t i = 0; i <= bins; ++i)
    histogram.edges.push_back(first * std::exp(step * static_cast<double>(i)));
  for (const ShownPose& pose : view.poses) {
    auto& counts = histogram.counts.emplace_back(bins);
    for (const float distance : pose.distances) {
      const double place = distance > first ? std::log(distance / first) / step : 0;
      ++counts[std::min(static_cast<std::size_t>(place), bins - 1)];
    }
    histogram.medians.push_back(medianOf(pose.distances));
  }
  return histogram;
}

} // namespace pcl_gpu_icp::view
