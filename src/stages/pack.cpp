#include "pack.h"

#include "kernels/layout.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

namespace pcl_gpu_icp::stages {

namespace {

constexpr std::size_t pivot_samples = 63;

/// Magnitudes of floats compare like their bits; what is not finite is at infinity's or above.
constexpr std::uint32_t infinity_bits = 0x7F800000;

std::uint32_t magnitudeBits(float x)
{
  std::uint32_t bits;
  std::memcpy(&bits, &x, sizeof(bits));
  return bits & 0x7FFFFFFF;
}

std::uint32_t largestMagnitudeBits(const float* p)
{
  return std::max({magnitudeBits(p[0]), magnitudeBits(p[1]), magnitudeBits(p[2])});
}

bool finite(const float* p) { return largestMagnitudeBits(p) < infinity_bits; }

class LargestCoordinate {
public:
  void add(std::uint32_t bits) { bits_ = std::max(bits_, bits); }
  float value() const
  {
    float largest;
    std::memcpy(&largest, &bits_, sizeof(largest));
    return largest;
  }

private:
  std::uint32_t bits_ = 0;
};

/// Exact to float32's rounding: the pivot is itself a float32 coordinate.
void writePoint(const float* p, const Pivot& pivot, float* row, std::size_t stride)
{
  row[0] = p[0] - static_cast<float>(pivot[0]);
  row[stride] = p[1] - static_cast<float>(pivot[1]);
  row[2 * stride] = p[2] - static_cast<float>(pivot[2]);
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
  queue.upload(pairs.rows, PAIR_ROWS * stride * sizeof(float), [&](void* memory) {
    auto* rows = static_cast<float*>(memory);
    LargestCoordinate largest_source, largest_target;
    // Every pair is written; the next one overwrites it unless it is finite. No branch depends on the data.
    std::size_t count = 0;
    for (std::size_t i = 0; i < source.count; ++i) {
      const float* p = source[i];
      const float* q = target[i];
      writePoint(p, source_pivot, rows + count, stride);
      writePoint(q, target_pivot, rows + 3 * std::size_t(stride) + count, stride);
      const std::uint32_t p_bits = largestMagnitudeBits(p), q_bits = largestMagnitudeBits(q);
      const bool both_finite = p_bits < infinity_bits && q_bits < infinity_bits;
      largest_source.add(both_finite ? p_bits : 0);
      largest_target.add(both_finite ? q_bits : 0);
      count += both_finite ? 1 : 0;
    }
    for (int row = 0; row < PAIR_ROWS; ++row)
      std::fill(rows + row * std::size_t(stride) + count, rows + (row + 1) * std::size_t(stride), 0.0F);
    pairs.count = static_cast<cl_uint>(count);
    pairs.resolution_sq = resolutionSquared(largest_source.value(), largest_target.value());
  });
  pairs.stride = stride;
}

float packCloud(opencl::Queue& queue, const Points& points, const Pivot& pivot, Cloud& cloud)
{
  const cl_uint stride = paddedStride(points.count);
  LargestCoordinate largest;
  queue.upload(cloud.rows, 3 * std::size_t(stride) * sizeof(float), [&](void* memory) {
    auto* rows = static_cast<float*>(memory);
    for (std::size_t i = 0; i < points.count; ++i) {
      writePoint(points[i], pivot, rows + i, stride);
      const std::uint32_t bits = largestMagnitudeBits(points[i]);
      largest.add(bits < infinity_bits ? bits : 0);
    }
  });
  cloud.stride = stride;
  cloud.count = static_cast<cl_uint>(points.count);
  return largest.value();
}

} // namespace pcl_gpu_icp::stages
