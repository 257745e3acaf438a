#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_gpu_icp {

/// Points with a coordinate beyond it take no part: up to it float32 holds the squares of the distances between a
/// source and a target.
constexpr float largest_coordinate = 1e18F;

/// Whether the coordinates are finite and none is beyond largest_coordinate.
inline bool takesPart(const float* xyz)
{
  // Not <=, which traps where the caller has NaN trap.
  return std::islessequal(std::abs(xyz[0]), largest_coordinate) &&
         std::islessequal(std::abs(xyz[1]), largest_coordinate) &&
         std::islessequal(std::abs(xyz[2]), largest_coordinate);
}

/// A view of `count` points, each starting with float x, y, z: point i is at `data + i * stride` bytes, or, with an
/// index, at `data + index[i] * stride` where successive entries of the index are `index_stride` bytes apart (so that
/// a member of pcl::Correspondence can serve). Nothing is owned.
struct Points {
  const void* data = nullptr;
  std::size_t count = 0;
  std::size_t stride = 4 * sizeof(float);
  const void* index = nullptr;
  std::size_t index_stride = sizeof(std::int32_t);

  std::size_t position(std::size_t i) const
  {
    return index ? *reinterpret_cast<const std::int32_t*>(static_cast<const char*>(index) + i * index_stride) : i;
  }
  const float* operator[](std::size_t i) const
  {
    return reinterpret_cast<const float*>(static_cast<const char*>(data) + position(i) * stride);
  }
};

/// A point about some pivot, and its Points::position().
struct PlacedPoint {
  float xyz[3];
  std::int32_t position;
};

/// A view of placed points.
inline Points viewOf(const std::vector<PlacedPoint>& points)
{
  return {points.data(), points.size(), sizeof(PlacedPoint)};
}

/// Source point `source` is matched with target point `target`, `squared_distance` apart.
/// The layout is that of pcl::Correspondence.
struct Correspondence {
  std::int32_t source;
  std::int32_t target;
  float squared_distance;
};

} // namespace pcl_gpu_icp
