#pragma once

#include <pcl_gpu_icp/icp_loop.h>

#include <array>
#include <vector>

namespace pcl_gpu_icp {

/// Anderson acceleration of the fixed-point iteration pose -> plain ICP's next pose (Walker and Ni 2011; on rigid
/// motions Zhang, Yao and Deng 2021): the next pose is where a linear model of the last steps has its fixed point.
class AndersonAcceleration {
public:
  /// Steps remembered.
  static constexpr std::size_t window = 5;

  /// \param origin poses are looked at as motions from here, by less than half a turn
  AndersonAcceleration(const RigidTransform& origin, const Lever& lever);

  /// Where to go after plain ICP led from `pose` to `next`.
  RigidTransform accelerated(const RigidTransform& pose, const RigidTransform& next);

  void forget() { steps_.clear(); }

private:
  /// A pose as a rotation vector times the lever's length, and the way of the lever's centre.
  using Coordinates = std::array<double, 6>;
  struct Step {
    Coordinates residual; ///< what the plain step changes
    Coordinates next;     ///< where it leads
  };

  Coordinates coordinatesOf(const RigidTransform& pose) const;
  RigidTransform poseAt(const Coordinates& coordinates) const;

  RigidTransform origin_;
  Lever lever_;
  std::vector<Step> steps_; ///< the newest last
};

} // namespace pcl_gpu_icp
