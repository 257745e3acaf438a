#pragma once

#include <pcl_gpu_icp/error.h>
#include <pcl_gpu_icp/points.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace pcl_gpu_icp {

/// What a caller's array holds at a position as Points::position() counts them: coordinates, a normal or a covariance.
inline const float* valuesAt(const Points& values, std::int32_t position)
{
  return reinterpret_cast<const float*>(static_cast<const char*>(values.data) +
                                        static_cast<std::ptrdiff_t>(position) *
                                            static_cast<std::ptrdiff_t>(values.stride));
}

/// \throws InvalidArgument when `count` values are not one for the point at that position of the caller's cloud
inline void requireOneEach(std::int32_t position, std::size_t count, const char* values)
{
  if (static_cast<std::size_t>(position) >= count)
    throw InvalidArgument(std::string("the ") + values + " are " + std::to_string(count) + ", and there is point " +
                          std::to_string(position));
}

} // namespace pcl_gpu_icp
