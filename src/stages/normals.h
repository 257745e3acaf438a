#pragma once

#include "match.h"

namespace pcl_gpu_icp::stages {

/// The normal of the surface at every query, from the covariance of its nearest target points.
class Normals {
public:
  /// \param queries in the target's frame
  /// \param k from 3 to NEAREST_MOST
  /// \param resolution_sq variance below which a direction is only the coordinates' rounding
  void enqueue(
      opencl::Queue& queue, const SourcePoints& queries, const TargetPoints& target, cl_uint k, float resolution_sq);

  /// Rows x, y, z of the queries' stride: unit vectors of either sign; NaN where the points do not span a plane.
  const opencl::Buffer& normals() const { return normals_; }

private:
  opencl::Buffer normals_{"normals"};
};

} // namespace pcl_gpu_icp::stages
