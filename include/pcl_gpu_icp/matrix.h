#pragma once

#include <pcl_gpu_icp/impl/matrix.hpp>

namespace pcl_gpu_icp {

/// A transform as PCL writes it, e.g. BatchResult::transform: Eigen::Matrix4f matrix = toMatrix(result.transform).
template <typename Scalar = float>
Eigen::Matrix<Scalar, 4, 4> toMatrix(const RigidTransform& transform)
{
  return detail::toMatrix<Scalar>(transform);
}

} // namespace pcl_gpu_icp
