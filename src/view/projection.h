#pragma once

#include "view/canvas.h"
#include "view/colours.h"
#include "view/pair_view.h"

#include <array>

namespace pcl_gpu_icp::view {

/// A direction to look in: the axes that point right and up.
struct Direction {
  const char* name;
  int right, up;
};
constexpr std::array<Direction, 3> directions{
    {{"from above", 0, 1}, {"from the front", 0, 2}, {"from the side", 1, 2}}};

/// A part of a picture.
struct Panel {
  int x, y, width, height;
};

/// Draws both clouds with the source at a pose.
/// \param box to show
/// \return pixels per unit of the files
double project(Canvas& canvas,
               const Panel& panel,
               const PairView& view,
               const ShownPose& pose,
               const Box& box,
               const Direction& direction);

} // namespace pcl_gpu_icp::view
