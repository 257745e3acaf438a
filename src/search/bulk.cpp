#include "bulk.h"

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp::search {

std::vector<const float*> samplesOf(const Points& points)
{
  constexpr std::size_t samples_at_most = 63;
  std::vector<const float*> samples;
  const auto sample = [&](std::size_t step) {
    for (std::size_t i = 0; i < points.count && samples.size() < samples_at_most; i += step)
      if (takesPart(points[i]))
        samples.push_back(points[i]);
  };
  sample(points.count / samples_at_most + 1);
  if (samples.empty())
    sample(1);
  return samples;
}

Bulk::Bulk(const std::vector<const float*>& samples)
{
  if (samples.empty())
    return;
  const std::size_t quarter = samples.size() / 4;
  double widest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> coordinates;
    coordinates.reserve(samples.size());
    for (const float* sample : samples)
      coordinates.push_back(sample[axis]);
    std::sort(coordinates.begin(), coordinates.end());
    median_[axis] = coordinates[coordinates.size() / 2];
    widest = std::max(widest, coordinates[coordinates.size() - 1 - quarter] - coordinates[quarter]);
  }
  if (widest > 0)
    reach_ = 1000 * widest;
}

bool Bulk::holds(const float* xyz) const
{
  return takesPart(xyz) && std::abs(xyz[0] - median_[0]) <= reach_ && std::abs(xyz[1] - median_[1]) <= reach_ &&
         std::abs(xyz[2] - median_[2]) <= reach_;
}

std::array<double, 3> Bulk::largest(const Points& points, const std::array<double, 3>& offset) const
{
  std::array<double, 3> largest{};
  for (std::size_t i = 0; i < points.count; ++i)
    if (holds(points[i]))
      for (int axis = 0; axis < 3; ++axis)
        largest[axis] = std::max(largest[axis], std::abs(offset[axis] + points[i][axis]));
  return largest;
}

} // namespace pcl_gpu_icp::search
