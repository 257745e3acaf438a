#pragma once

#include <cstdint>

namespace pcl_gpu_icp::view {

/// 0xRRGGBB.
using Colour = std::uint32_t;

/// From the palette of Okabe and Ito, which the colour-blind tell apart.
constexpr Colour source_colour = 0xe69f00;
constexpr Colour target_colour = 0x0072b2;
constexpr Colour both_colour = 0x4a4a55; ///< where both clouds are

} // namespace pcl_gpu_icp::view
