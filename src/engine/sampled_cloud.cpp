#include "sampled_cloud.h"

#include "search/box_tree.h"
#include "search/surroundings.h"

#include <pcl_gpu_icp/icp_loop.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace pcl_gpu_icp {

namespace {

constexpr std::size_t points_at_most = 1 << 14;

/// Without those that repeat another: at a pile of them there is no spacing.
std::vector<PlacedPoint> distinct(std::vector<PlacedPoint> points)
{
  search::dropCoincident(points);
  return points;
}

/// Enough to tell shares by, and few beside what an alignment of so many does.
std::size_t samplesOf(std::size_t points) { return std::clamp<std::size_t>(points / 32, 160, 512); }

} // namespace

std::vector<PlacedPoint> thinned(const Points& cloud, std::size_t most, const Place& pivot)
{
  constexpr double golden = 0.6180339887498949;
  const std::size_t count = std::min(cloud.count, most);
  if (count == 0)
    return {};
  const double stretch = static_cast<double>(cloud.count) / static_cast<double>(count);
  std::vector<PlacedPoint> kept;
  kept.reserve(count);
  for (std::size_t n = 0; n < count; ++n) {
    const double turns = golden * static_cast<double>(n);
    const double within = count < cloud.count ? turns - std::floor(turns) : 0;
    const auto place = static_cast<std::size_t>((static_cast<double>(n) + within) * stretch);
    const float* point = cloud[std::min(place, cloud.count - 1)];
    if (!takesPart(point))
      continue;
    PlacedPoint& placed = kept.emplace_back();
    for (int axis = 0; axis < 3; ++axis)
      placed.xyz[axis] = static_cast<float>(point[axis] - pivot[axis]);
    placed.position = static_cast<std::int32_t>(kept.size() - 1);
  }
  return kept;
}

std::vector<Place> placesOf(const std::vector<PlacedPoint>& points, const RigidTransform& pose)
{
  std::vector<Place> places;
  places.reserve(points.size());
  for (const PlacedPoint& point : points)
    places.push_back(pose(point.xyz[0], point.xyz[1], point.xyz[2]));
  return places;
}

double share(std::size_t part, std::size_t whole)
{
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
}

double medianOf(std::vector<double> values)
{
  if (values.empty())
    return std::numeric_limits<double>::infinity();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

SampledCloud::SampledCloud(const Points& all, const Place& at, unsigned threads)
: pivot(at)
, points(distinct(thinned(all, points_at_most, at)))
, samples(thinned(viewOf(points), samplesOf(points.size())))
{
  // Within three spacings of a point of a surface there are some thirty others.
  constexpr double fewest = 10, most = 90, pi = 3.14159265358979;
  constexpr std::size_t enough_points = 1 << 10, enough_samples = 64;
  const auto some = thinned(viewOf(points), enough_points);
  const auto places = placesOf(thinned(viewOf(samples), enough_samples));
  double radius = surfaceSpacing(viewOf(some));
  for (const bool last : {false, false, true}) {
    std::vector<double> counts;
    for (const search::Nearby& around : search::foundAround<search::Nearby>(places, some, radius, threads))
      counts.push_back(static_cast<double>(around.count));
    const double count = medianOf(std::move(counts));
    spacing = radius * std::sqrt(pi / std::max(count, 1.0));
    if (last || (count > fewest && count < most))
      break;
    radius = count > fewest ? near_spacings * spacing : 2 * radius;
  }
  spacing *= std::sqrt(share(some.size(), points.size()));
}

} // namespace pcl_gpu_icp
