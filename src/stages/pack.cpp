#include "pack.h"

#include "kernels/layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace pcl_gpu_icp::stages {

namespace {

constexpr std::size_t pivot_samples = 63;

bool finite(const float* p)
{
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

float largestCoordinate(const float* p, float largest)
{
  return std::max({largest, std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
}

} // namespace

Pivot pivotOf(const Points& points)
{
  std::array<std::vector<float>, 3> samples;
  const std::size_t step = points.count / pivot_samples + 1;
  const auto sample = [&](std::size_t first, std::size_t stride) {
    for (std::size_t i = first; i < points.count && samples[0].size() < pivot_samples; i += stride)
      if (finite(points[i]))
        for (int axis = 0; axis < 3; ++axis)
          samples[axis].push_back(points[i][axis]);
  };
  sample(0, step);
  if (samples[0].empty())
    sample(0, 1);
  Pivot pivot{};
  if (samples[0].empty())
    return pivot;
  for (int axis = 0; axis < 3; ++axis) {
    const auto middle = samples[axis].begin() + samples[axis].size() / 2;
    std::nth_element(samples[axis].begin(), middle, samples[axis].end());
    pivot[axis] = *middle;
  }
  return pivot;
}

float resolutionSquared(float largest_source_coordinate, float largest_target_coordinate)
{
  const float half_ulp = std::numeric_limits<float>::epsilon() / 2;
  return (half_ulp * largest_source_coordinate) * (half_ulp * largest_target_coordinate);
}

void packPairs(opencl::Queue& queue,
               const Points& source,
               const Points& target,
               const Pivot& source_pivot,
               const Pivot& target_pivot,
               Pairs& pairs)
{
  const cl_uint stride = paddedStride(source.count);
  std::size_t count = 0;
  float largest_source = 0, largest_target = 0;
  queue.upload(pairs.rows, PAIR_ROWS * stride * sizeof(float), [&](void* memory) {
    auto* rows = static_cast<float*>(memory);
    for (std::size_t i = 0; i < source.count; ++i) {
      const float* p = source[i];
      const float* q = target[i];
      if (!finite(p) || !finite(q))
        continue;
      for (int axis = 0; axis < 3; ++axis) {
        rows[axis * stride + count] = static_cast<float>(p[axis] - source_pivot[axis]);
        rows[(3 + axis) * stride + count] = static_cast<float>(q[axis] - target_pivot[axis]);
      }
      largest_source = largestCoordinate(p, largest_source);
      largest_target = largestCoordinate(q, largest_target);
      ++count;
    }
    for (int row = 0; row < PAIR_ROWS; ++row)
      std::fill(rows + row * stride + count, rows + (row + 1) * stride, 0.0F);
  });
  pairs.stride = stride;
  pairs.count = static_cast<cl_uint>(count);
  pairs.resolution_sq = resolutionSquared(largest_source, largest_target);
}

float packCloud(opencl::Queue& queue, const Points& points, const Pivot& pivot, Cloud& cloud)
{
  const cl_uint stride = paddedStride(points.count);
  float largest = 0;
  queue.upload(cloud.rows, 3 * stride * sizeof(float), [&](void* memory) {
    auto* rows = static_cast<float*>(memory);
    for (std::size_t i = 0; i < points.count; ++i) {
      const float* p = points[i];
      for (int axis = 0; axis < 3; ++axis)
        rows[axis * stride + i] = static_cast<float>(p[axis] - pivot[axis]);
      if (finite(p))
        largest = largestCoordinate(p, largest);
    }
  });
  cloud.stride = stride;
  cloud.count = static_cast<cl_uint>(points.count);
  return largest;
}

} // namespace pcl_gpu_icp::stages
