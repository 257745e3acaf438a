#pragma once

#include "match.h"

#include <array>

namespace pcl_gpu_icp::stages {

/// Copies a normal for each target point, in the order of the leaves; those that are not finite become zero.
void packNormals(opencl::Queue& queue, const std::vector<std::array<float, 3>>& normals, opencl::Buffer& leaves);

/// The sums of linearised point-to-plane estimation over matched pairs. See kernels/plane.cl.
class Plane {
public:
  /// Writes PLANE_SUMS values.
  /// \param pose from the source's frame (about its pivot) to the target's
  /// \param matches as Match::matches()
  /// \param normals as packNormals() leaves them
  /// \param centre in the target's frame; float32 values
  void enqueue(opencl::Queue& queue,
               const SourcePoints& source,
               const RigidTransform& pose,
               const opencl::Buffer& matches,
               const TargetPoints& target,
               const opencl::Buffer& normals,
               const std::array<double, 3>& centre,
               std::size_t real_bytes,
               const opencl::Buffer& total);

private:
  opencl::Buffer partials_{"partial point-to-plane sums"};
};

} // namespace pcl_gpu_icp::stages
