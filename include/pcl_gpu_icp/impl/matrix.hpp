#pragma once

#include <pcl_gpu_icp/rigid_transform.h>

#include <Eigen/Core>

namespace pcl_gpu_icp::detail {

template <typename Scalar>
RigidTransform toRigidTransform(const Eigen::Matrix<Scalar, 4, 4>& matrix)
{
  RigidTransform transform;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      transform.rotation[3 * i + j] = matrix(i, j);
    transform.translation[i] = matrix(i, 3);
  }
  return transform;
}

template <typename Scalar>
Eigen::Matrix<Scalar, 4, 4> toMatrix(const RigidTransform& transform)
{
  Eigen::Matrix<Scalar, 4, 4> matrix = Eigen::Matrix<Scalar, 4, 4>::Identity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      matrix(i, j) = static_cast<Scalar>(transform.rotation[3 * i + j]);
    matrix(i, 3) = static_cast<Scalar>(transform.translation[i]);
  }
  return matrix;
}

} // namespace pcl_gpu_icp::detail
