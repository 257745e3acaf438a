#pragma once

#include <pcl_gpu_icp/export.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <array>

namespace pcl_gpu_icp {

/// What an alignment may change of the guess: how the source may move, in the target's frame.
enum class Motions {
  Rigid,       ///< all six: turns about and shifts along x, y and z
  Planar,      ///< shifts along x and y, turns about z: robots on a floor, 2-D lidars
  Yaw,         ///< shifts along x, y and z, turns about z: what stays upright
  Translation, ///< shifts alone: gantries, clouds of known attitude
};

PCL_GPU_ICP_API const char* toString(Motions motions);

/// Which of the six a motion may be: turns about x, y, z, then shifts along x, y, z.
PCL_GPU_ICP_API std::array<bool, 6> unknownsOf(Motions motions);

/// What is left of a motion that is one of those but for rounding.
/// \param anchor which is mapped to where it was, along the axes that it may be shifted along
PCL_GPU_ICP_API RigidTransform restricted(const RigidTransform& motion,
                                          Motions motions,
                                          const std::array<double, 3>& anchor);

} // namespace pcl_gpu_icp
