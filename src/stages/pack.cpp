#include "pack.h"

#include "kernels/layout.h"
#include "search/bulk.h"

#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace pcl_gpu_icp::stages {

namespace {

constexpr std::size_t points_at_a_time = 8192; ///< for a host thread
constexpr std::size_t points_in_cache = 256;   ///< written, then looked at again

bool finite(float x)
{
  std::uint32_t bits;
  std::memcpy(&bits, &x, sizeof(bits));
  return (bits & 0x7F800000) != 0x7F800000;
}

/// Writes points [first, first + n), less the pivot, to three rows. Exact to float32's rounding: the pivot is itself a
/// float32 coordinate.
void writeRows(
    const Points& points, std::size_t first, std::size_t n, const Pivot& pivot, float* rows, std::size_t stride)
{
  const float x = static_cast<float>(pivot[0]), y = static_cast<float>(pivot[1]), z = static_cast<float>(pivot[2]);
  const auto write = [&](std::size_t i, const float* p) {
    rows[i] = p[0] - x;
    rows[i + stride] = p[1] - y;
    rows[i + 2 * stride] = p[2] - z;
  };
  if (points.index) {
    for (std::size_t i = 0; i < n; ++i)
      write(i, points[first + i]);
    return;
  }
  const char* p = static_cast<const char*>(points.data) + first * points.stride;
  for (std::size_t i = 0; i < n; ++i, p += points.stride)
    write(i, reinterpret_cast<const float*>(p));
}

/// Whether the first n entries of every row of pairs are finite. No branch: it is vectorised.
bool allFinite(const float* rows, std::size_t stride, std::size_t n)
{
  unsigned strays = 0;
  for (std::size_t row = 0; row < PAIR_ROWS; ++row)
    for (std::size_t i = 0; i < n; ++i)
      strays |= finite(rows[row * stride + i]) ? 0U : 1U;
  return strays == 0;
}

/// Moves the finite pairs among the first n to the front; returns how many they are.
std::size_t compact(float* rows, std::size_t stride, std::size_t n)
{
  std::size_t kept = 0;
  for (std::size_t i = 0; i < n; ++i) {
    bool keep = true;
    for (std::size_t row = 0; row < PAIR_ROWS; ++row)
      keep = keep && finite(rows[row * stride + i]);
    for (std::size_t row = 0; row < PAIR_ROWS; ++row)
      rows[row * stride + kept] = rows[row * stride + i];
    kept += keep ? 1 : 0;
  }
  return kept;
}

} // namespace

Placement placementOf(const Points& points)
{
  const auto samples = search::samplesOf(points);
  const search::Bulk bulk(samples);
  Placement placement;
  placement.pivot = bulk.median();
  float largest = 0;
  for (const float* sample : samples)
    if (bulk.holds(sample))
      largest = std::max({largest, std::abs(sample[0]), std::abs(sample[1]), std::abs(sample[2])});
  placement.rounding = largest * std::numeric_limits<float>::epsilon() / 2;
  return placement;
}

void packPairs(opencl::Queue& queue,
               const Points& source,
               const Points& target,
               const Placement& p,
               const Placement& q,
               Pairs& pairs)
{
  const std::size_t stride = paddedStride(source.count);
  std::size_t count = source.count;
  queue.upload(pairs.rows, PAIR_ROWS * stride * sizeof(float), [&](void* memory) {
    auto* rows = static_cast<float*>(memory);
    std::atomic<bool> all_finite{true};
    parallelFor(count, points_at_a_time, effectiveThreads(0), [&](std::size_t begin, std::size_t end) {
      for (std::size_t first = begin; first < end; first += points_in_cache) {
        const std::size_t points = std::min(points_in_cache, end - first);
        writeRows(source, first, points, p.pivot, rows + first, stride);
        writeRows(target, first, points, q.pivot, rows + 3 * stride + first, stride);
        if (!allFinite(rows + first, stride, points))
          all_finite = false;
      }
    });
    if (!all_finite)
      count = compact(rows, stride, count);
    for (std::size_t row = 0; row < PAIR_ROWS; ++row)
      std::fill(rows + row * stride + count, rows + (row + 1) * stride, 0.0F);
  });
  pairs.stride = static_cast<cl_uint>(stride);
  pairs.count = static_cast<cl_uint>(count);
  pairs.resolution_sq = p.rounding * q.rounding;
}

void packCloud(opencl::Queue& queue, const Points& points, const Placement& placement, Cloud& cloud)
{
  const std::size_t stride = paddedStride(points.count);
  queue.upload(cloud.rows, 3 * stride * sizeof(float), [&](void* memory) {
    auto* rows = static_cast<float*>(memory);
    parallelFor(points.count, points_at_a_time, effectiveThreads(0), [&](std::size_t begin, std::size_t end) {
      writeRows(points, begin, end - begin, placement.pivot, rows + begin, stride);
    });
  });
  cloud.stride = static_cast<cl_uint>(stride);
  cloud.count = static_cast<cl_uint>(points.count);
}

} // namespace pcl_gpu_icp::stages
