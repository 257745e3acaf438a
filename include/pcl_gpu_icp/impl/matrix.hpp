#pragma once

#include <pcl_gpu_icp/rigid_transform.h>

#include <Eigen/Core>

#include <cmath>

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

/// Whether the last row is 0 0 0 1, but for what a product of transforms may make of it, and the rest isRigid().
template <typename Scalar>
bool isRigid(const Eigen::Matrix<Scalar, 4, 4>& matrix)
{
  constexpr double tolerance = 1e-6;
  bool is_affine = true;
  for (int column = 0; column < 4; ++column)
    is_affine = is_affine && std::abs(matrix(3, column) - (column == 3 ? 1 : 0)) <= tolerance;
  return is_affine && pcl_gpu_icp::isRigid(toRigidTransform<Scalar>(matrix));
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
