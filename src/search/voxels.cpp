#include "voxels.h"

#include "box_tree.h"
#include "bulk.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

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

/// Numbers voxels as they are first met.
class VoxelNumbers {
public:
  explicit VoxelNumbers(std::size_t most)
  {
    while (keys_.size() < 2 * most)
      keys_.resize(2 * keys_.size());
    std::fill(keys_.begin(), keys_.end(), none);
    numbers_.resize(keys_.size());
  }

  std::size_t operator()(std::int64_t voxel)
  {
    std::size_t slot = (static_cast<std::uint64_t>(voxel) * 0x9E3779B97F4A7C15) >> 20 & (keys_.size() - 1);
    while (keys_[slot] != voxel && keys_[slot] != none)
      slot = (slot + 1) & (keys_.size() - 1);
    if (keys_[slot] == none) {
      keys_[slot] = voxel;
      numbers_[slot] = count_++;
    }
    return numbers_[slot];
  }

  std::size_t count() const { return count_; }

private:
  std::vector<std::int64_t> keys_ = std::vector<std::int64_t>(16); ///< open addressing
  std::vector<std::uint32_t> numbers_;
  std::uint32_t count_ = 0;
};

std::size_t occupied(const std::vector<PlacedPoint>& points, double size)
{
  VoxelNumbers numbers(points.size());
  for (const PlacedPoint& point : points) {
    const std::int64_t voxel = voxelOf(point.xyz, size);
    if (voxel != none)
      numbers(voxel);
  }
  return numbers.count();
}

} // namespace

std::vector<PlacedPoint> voxelMeans(const std::vector<PlacedPoint>& points, double size)
{
  struct Sum {
    std::int64_t voxel;
    double xyz[3], count;
  };
  VoxelNumbers numbers(points.size());
  std::vector<Sum> sums;
  for (const PlacedPoint& point : points) {
    const std::int64_t voxel = voxelOf(point.xyz, size);
    if (voxel == none)
      continue;
    const std::size_t number = numbers(voxel);
    if (number == sums.size())
      sums.push_back({voxel, {0, 0, 0}, 0});
    Sum& sum = sums[number];
    for (int axis = 0; axis < 3; ++axis)
      sum.xyz[axis] += point.xyz[axis];
    ++sum.count;
  }
  std::sort(sums.begin(), sums.end(), [](const Sum& a, const Sum& b) { return a.voxel < b.voxel; });
  std::vector<PlacedPoint> means;
  means.reserve(sums.size());
  for (const auto& [voxel, xyz, count] : sums)
    means.push_back(
        {{static_cast<float>(xyz[0] / count), static_cast<float>(xyz[1] / count), static_cast<float>(xyz[2] / count)},
         static_cast<std::int32_t>(means.size())});
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
  dropCoincident(samples);
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
