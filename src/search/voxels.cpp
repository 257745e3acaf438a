#include "voxels.h"

#include "bulk.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace pcl_gpu_icp::search {

namespace {

constexpr std::int64_t none = -1;

/// Three times 21 bits; none: beyond them.
std::int64_t voxelOf(const float* xyz, double size)
{
  constexpr std::int64_t half = 1 << 20;
  std::int64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double place = std::floor(xyz[axis] / size);
    if (!(std::abs(place) < half))
      return none;
    key = key << 21 | (static_cast<std::int64_t>(place) + half);
  }
  return key;
}

std::size_t occupied(const std::vector<PlacedPoint>& points, double size)
{
  std::vector<std::int64_t> voxels;
  voxels.reserve(points.size());
  for (const PlacedPoint& point : points)
    voxels.push_back(voxelOf(point.xyz, size));
  std::sort(voxels.begin(), voxels.end());
  return static_cast<std::size_t>(std::unique(voxels.begin(), voxels.end()) - voxels.begin());
}

} // namespace

std::vector<PlacedPoint> voxelMeans(const std::vector<PlacedPoint>& points, double size)
{
  std::vector<std::pair<std::int64_t, std::size_t>> places;
  places.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::int64_t voxel = voxelOf(points[i].xyz, size);
    if (voxel != none)
      places.emplace_back(voxel, i);
  }
  std::sort(places.begin(), places.end());
  std::vector<PlacedPoint> means;
  for (auto first = places.begin(); first != places.end();) {
    double sum[3] = {0, 0, 0};
    auto last = first;
    for (; last != places.end() && last->first == first->first; ++last)
      for (int axis = 0; axis < 3; ++axis)
        sum[axis] += points[last->second].xyz[axis];
    const auto n = static_cast<double>(last - first);
    means.push_back({{static_cast<float>(sum[0] / n), static_cast<float>(sum[1] / n), static_cast<float>(sum[2] / n)},
                     static_cast<std::int32_t>(means.size())});
    first = last;
  }
  return means;
}

double voxelSizeFor(const std::vector<PlacedPoint>& points, std::size_t voxels, double fewest_each)
{
  // Of a surface the number of voxels falls with the square of their size; a few steps come near enough.
  constexpr int steps = 8;
  constexpr std::size_t samples_at_most = 1 << 16;
  std::vector<PlacedPoint> samples;
  const Bulk bulk(viewOf(points));
  for (std::size_t i = 0; i < points.size(); i += points.size() / samples_at_most + 1)
    if (bulk.holds(points[i].xyz))
      samples.push_back(points[i]);
  const auto before = [](const PlacedPoint& a, const PlacedPoint& b) {
    return std::lexicographical_compare(a.xyz, a.xyz + 3, b.xyz, b.xyz + 3);
  };
  const auto same = [](const PlacedPoint& a, const PlacedPoint& b) { return std::equal(a.xyz, a.xyz + 3, b.xyz); };
  std::sort(samples.begin(), samples.end(), before);
  samples.erase(std::unique(samples.begin(), samples.end(), same), samples.end());
  voxels = std::min(voxels, static_cast<std::size_t>(static_cast<double>(samples.size()) / fewest_each));
  double extent = 0;
  for (const double largest : bulk.largest(viewOf(points)))
    extent = std::max(extent, largest);
  if (voxels == 0)
    return 0;
  double size = extent / std::sqrt(static_cast<double>(voxels));
  for (int step = 0; step < steps && size > 0; ++step)
    size *= std::sqrt(static_cast<double>(occupied(samples, size)) / static_cast<double>(voxels));
  return size;
}

} // namespace pcl_gpu_icp::search
