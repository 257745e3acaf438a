#include "view/pair_view.h"

#include <pcl_gpu_icp/parallel_for.h>
#include <pcl_gpu_icp/search/nearest_index.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <random>

namespace pcl_gpu_icp::view {
namespace {

float quantile(std::vector<float>& values, double share)
{
  const auto place = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

ShownCloud shownOf(const Cloud& cloud, std::size_t most)
{
  std::vector<std::size_t> all(cloud.points.count), drawn;
  std::iota(all.begin(), all.end(), 0);
  std::sample(all.begin(), all.end(), std::back_inserter(drawn), most, std::minstd_rand());

  ShownCloud shown;
  shown.all = all.size();
  shown.xyz.resize(3 * drawn.size());
  std::vector<float> values(drawn.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(drawn.begin(), drawn.end(), values.begin(), [&](std::size_t i) { return cloud.points[i][axis]; });
    const double middle = medianOf(values);
    shown.centre[axis] = cloud.origin[axis] + middle;
    for (std::size_t i = 0; i < drawn.size(); ++i)
      shown.xyz[3 * i + axis] = static_cast<float>(cloud.points[drawn[i]][axis] - middle);
  }
  return shown;
}

class DistanceMeter {
public:
  DistanceMeter(const Cloud& target, const std::array<double, 3>& centre)
  {
    index_.build(target.points);
    for (int axis = 0; axis < 3; ++axis)
      shift_[axis] = centre[axis] - target.origin[axis];
  }

  std::vector<float> distances(const ShownCloud& source, const RigidTransform& transform) const
  {
    std::vector<float> distances(source.size());
    parallelFor(
        distances.size(), search::queries_at_a_time, effectiveThreads(0), [&](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) {
            const float* point = &source.xyz[3 * i];
            const auto moved = transform(point[0], point[1], point[2]);
            float query[3];
            for (int axis = 0; axis < 3; ++axis)
              query[axis] = static_cast<float>(moved[axis] + shift_[axis]);
            distances[i] = std::sqrt(index_.nearest(query).squared_distance);
          }
        });
    return distances;
  }

private:
  search::NearestIndex index_;
  std::array<double, 3> shift_{}; ///< from about the centre to the target's coordinates
};

void extend(Box& box, const std::vector<std::array<double, 3>>& points)
{
  constexpr double few = 0.01; // of the points on either side: they count up to
  constexpr float reach = 0.5; // of the extent of the others beyond it
  std::vector<float> values(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(points.begin(), points.end(), values.begin(), [axis](const auto& point) {
      return static_cast<float>(point[axis]);
    });
    const float low = quantile(values, few), high = quantile(values, 1 - few);
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    box.low[axis] = std::min<double>(box.low[axis], std::max(*least, low - reach * (high - low)));
    box.high[axis] = std::max<double>(box.high[axis], std::min(*most, high + reach * (high - low)));
  }
}

std::vector<std::array<double, 3>> placed(const ShownCloud& cloud, const RigidTransform& transform)
{
  std::vector<std::array<double, 3>> points(cloud.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = transform(cloud.xyz[3 * i], cloud.xyz[3 * i + 1], cloud.xyz[3 * i + 2]);
  return points;
}

} // namespace

double medianOf(std::vector<float> values) { return quantile(values, 0.5); }

PairView viewOf(const Cloud& source, const Cloud& target, const std::vector<NamedPose>& poses, std::size_t most)
{
  PairView view{shownOf(source, most), shownOf(target, most), {}};
  const DistanceMeter meter(target, view.target.centre);
  for (const NamedPose& pose : poses) {
    const RigidTransform transform = recentred(pose.transform, view.source.centre, view.target.centre);
    view.poses.push_back({pose.name, transform, meter.distances(view.source, transform)});
  }
  return view;
}

Box frameOf(const PairView& view, const ShownPose& pose)
{
  Box box; // the target's centre is within
  extend(box, placed(view.target, RigidTransform()));
  extend(box, placed(view.source, pose.transform));
  return box;
}

} // namespace pcl_gpu_icp::view
