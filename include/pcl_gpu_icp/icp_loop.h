#pragma once

#include <pcl_gpu_icp/export.h>
#include <pcl_gpu_icp/rigid_transform.h>

namespace pcl_gpu_icp {

/// What the ICP loop asks of its surroundings. Transforms map source to target coordinates.
class PCL_GPU_ICP_API IcpSteps {
public:
  virtual ~IcpSteps() = default;

  /// Finds the correspondences of the source at `pose`. False: too few to go on.
  virtual bool match(const RigidTransform& pose) = 0;

  /// The rigid transform that takes the matched source points at `pose` onto their targets.
  virtual RigidTransform estimateIncrement(const RigidTransform& pose) = 0;

  /// Whether to stop, after `increment` led to `pose`.
  virtual bool finished(const RigidTransform& increment, const RigidTransform& pose) = 0;
};

/// Iterative closest point (Besl and McKay 1992): match, estimate, move, until finished.
/// \return the accumulated transform
PCL_GPU_ICP_API RigidTransform iterate(IcpSteps& steps, const RigidTransform& guess);

} // namespace pcl_gpu_icp
