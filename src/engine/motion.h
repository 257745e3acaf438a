#pragma once

#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace pcl_gpu_icp {

/// How far a cloud moves from one pose to the next, at most: as far as the corners of its box.
class Motion {
public:
  void restart(const std::vector<PlacedPoint>& points)
  {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    std::array<float, 3> low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
    for (const PlacedPoint& point : points)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], point.xyz[axis]);
        high[axis] = std::max(high[axis], point.xyz[axis]);
      }
    for (int corner = 0; corner < 8; ++corner)
      for (int axis = 0; axis < 3; ++axis)
        corners_[corner][axis] = ((corner >> axis) & 1) != 0 ? high[axis] : low[axis];
    last_pose_.reset();
  }

  /// The step from the last pose; infinite at first.
  double stepTo(const RigidTransform& pose)
  {
    double step = last_pose_ ? 0 : std::numeric_limits<double>::infinity();
    if (last_pose_)
      for (const auto& corner : corners_) {
        const auto from = (*last_pose_)(corner[0], corner[1], corner[2]), to = pose(corner[0], corner[1], corner[2]);
        step = std::max(step, std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]));
      }
    last_pose_ = pose;
    return step;
  }

private:
  std::array<std::array<double, 3>, 8> corners_{};
  std::optional<RigidTransform> last_pose_;
};

} // namespace pcl_gpu_icp
