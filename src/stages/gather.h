#pragma once

#include "pairs.h"

#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_transform.h>

namespace pcl_gpu_icp::stages {

/// Forms pairs from two clouds that stay on the device: only the matches and the pose travel.
class Gather {
public:
  /// \param pose from the source's frame (about its pivot) to the target's
  void enqueue(opencl::Queue& queue,
               const Cloud& source,
               const Cloud& target,
               const Correspondence* correspondences,
               std::size_t count,
               const RigidTransform& pose,
               Pairs& pairs);

private:
  opencl::Buffer matches_{"matches"};
};

} // namespace pcl_gpu_icp::stages
