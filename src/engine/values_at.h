#pragma once

#include <pcl_gpu_icp/points.h>

#include <cstddef>
#include <cstdint>

namespace pcl_gpu_icp {

/// What a caller's array holds at a position as Points::position() counts them: coordinates, a normal or a covariance.
inline const float* valuesAt(const Points& values, std::int32_t position)
{
  return reinterpret_cast<const float*>(static_cast<const char*>(values.data) +
                                        static_cast<std::ptrdiff_t>(position) *
                                            static_cast<std::ptrdiff_t>(values.stride));
}

} // namespace pcl_gpu_icp
