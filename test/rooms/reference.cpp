#include "reference.h"

#include <Eigen/SVD>

#include <cmath>

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

Reference referenceOf(const Matrix3Xd& source, const Matrix3Xd& target)
{
  Reference reference;
  reference.source_centroid = source.rowwise().mean();
  reference.target_centroid = target.rowwise().mean();
  reference.source_demeaned = source.colwise() - reference.source_centroid;
  reference.target_demeaned = target.colwise() - reference.target_centroid;
  reference.H = reference.source_demeaned * reference.target_demeaned.transpose();
  // Of dynamic size: GCC 12 takes the fixed-size one's values for uninitialised.
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(reference.H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  reference.S = svd.singularValues();
  Matrix3d V = svd.matrixV();
  if (V.determinant() * svd.matrixU().determinant() < 0)
    V.col(2) *= -1;
  reference.R = V * svd.matrixU().transpose();
  reference.t = reference.target_centroid - reference.R * reference.source_centroid;
  return reference;
}

Reference referenceOf(const Cloud& source, const Cloud& target)
{
  return referenceOf(Matrix3Xd(source.cast<double>()), Matrix3Xd(target.cast<double>()));
}

Matrix3d matrixOf(const std::array<double, 9>& row_major)
{
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(row_major.data());
}

Vector3d vectorOf(const std::array<double, 3>& vector) { return Eigen::Map<const Vector3d>(vector.data()); }

std::array<double, 9> rowMajor(const Matrix3d& matrix)
{
  std::array<double, 9> result{};
  for (int i = 0; i < 9; ++i)
    result[i] = matrix(i / 3, i % 3);
  return result;
}

std::array<double, 3> arrayOf(const Vector3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

Isometry3d isometryOf(const RigidTransform& transform)
{
  Isometry3d isometry = Isometry3d::Identity();
  isometry.linear() = matrixOf(transform.rotation);
  isometry.translation() = vectorOf(transform.translation);
  return isometry;
}

RigidTransform transformOf(const Isometry3d& isometry)
{
  return {rowMajor(isometry.linear()), arrayOf(isometry.translation())};
}

Isometry3d motion(const Vector3d& axis, double angle, const Vector3d& translation)
{
  Isometry3d result = Isometry3d::Identity();
  result.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  result.translation() = translation;
  return result;
}

Cloud moved(const Cloud& cloud, const Isometry3d& motion)
{
  return (motion * Matrix3Xd(cloud.cast<double>())).cast<float>();
}

double rmsDifference(const Isometry3d& a, const Isometry3d& b, const Cloud& points)
{
  const Matrix3Xd p = points.cast<double>();
  return std::sqrt((a * p - b * p).squaredNorm() / static_cast<double>(p.cols()));
}

double rmsResidual(const Isometry3d& transform, const Cloud& source, const Cloud& target)
{
  const Matrix3Xd p = source.cast<double>(), q = target.cast<double>();
  return std::sqrt((transform * p - q).squaredNorm() / static_cast<double>(p.cols()));
}

double Random::uniform(double low, double high)
{
  return std::uniform_real_distribution<double>(low, high)(generator_);
}

std::size_t Random::count(std::size_t low, std::size_t high)
{
  return std::uniform_int_distribution<std::size_t>(low, high)(generator_);
}

Vector3d Random::direction()
{
  std::normal_distribution<double> normal;
  return Vector3d(normal(generator_), normal(generator_), normal(generator_)).normalized();
}

Matrix3d Random::rotation() { return Eigen::AngleAxisd(uniform(-EIGEN_PI, EIGEN_PI), direction()).toRotationMatrix(); }

Isometry3d Random::motion(double reach)
{
  Isometry3d result = Isometry3d::Identity();
  result.linear() = rotation();
  result.translation() = Vector3d(uniform(-reach, reach), uniform(-reach, reach), uniform(-reach, reach));
  return result;
}

Cloud Random::cloud(std::size_t n, const Vector3d& half_extents, const Vector3d& centre)
{
  Cloud cloud(3, n);
  for (std::size_t i = 0; i < n; ++i)
    for (int axis = 0; axis < 3; ++axis)
      cloud(axis, i) = static_cast<float>(centre[axis] + uniform(-1, 1) * half_extents[axis]);
  return cloud;
}

Cloud Random::directions(std::size_t n)
{
  Cloud unit_vectors(3, n);
  for (int i = 0; i < unit_vectors.cols(); ++i)
    unit_vectors.col(i) = direction().cast<float>();
  return unit_vectors;
}

Cloud lattice(std::size_t n)
{
  const auto side = static_cast<int>(std::ceil(std::cbrt(static_cast<double>(n))));
  Cloud cloud(3, n);
  for (int i = 0; i < cloud.cols(); ++i)
    cloud.col(i) = Eigen::Vector3f(i % side - side / 2, i / side % side - side / 2, i / (side * side) - side / 2);
  return cloud;
}

Cloud snapped(const Cloud& cloud)
{
  return cloud.unaryExpr([](float x) { return std::round(x * 1024.0F) / 1024.0F; });
}

} // namespace pcl_gpu_icp::test
