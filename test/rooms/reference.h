#pragma once

#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <random>

// The tests' own clouds and their own answers: plain double precision on the host, with Eigen's SVD.

namespace pcl_gpu_icp::test {

/// A cloud: a column per point.
using Cloud = Eigen::Matrix3Xf;

inline Points viewOf(const Cloud& cloud)
{
  return {cloud.data(), static_cast<std::size_t>(cloud.cols()), 3 * sizeof(float), nullptr, 0};
}

/// Between two points, in FLANN's order of operations.
inline float squaredDistance(const float* a, const float* b)
{
  float sum = 0;
  for (int axis = 0; axis < 3; ++axis)
    sum += (a[axis] - b[axis]) * (a[axis] - b[axis]);
  return sum;
}

/// The five stages in double precision.
struct Reference {
  Eigen::Vector3d source_centroid, target_centroid;
  Eigen::Matrix3Xd source_demeaned, target_demeaned;
  Eigen::Matrix3d H;
  Eigen::Vector3d S;
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
};

Reference referenceOf(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target);
Reference referenceOf(const Cloud& source, const Cloud& target);

/// Row-major arrays of the library as Eigen matrices.
Eigen::Matrix3d matrixOf(const std::array<double, 9>& row_major);
Eigen::Vector3d vectorOf(const std::array<double, 3>& vector);
std::array<double, 9> rowMajor(const Eigen::Matrix3d& matrix);
std::array<double, 3> arrayOf(const Eigen::Vector3d& vector);

Eigen::Isometry3d isometryOf(const RigidTransform& transform);
RigidTransform transformOf(const Eigen::Isometry3d& isometry);

/// Turns by `angle` about `axis` through the origin, then moves by `translation`.
Eigen::Isometry3d motion(const Eigen::Vector3d& axis, double angle, const Eigen::Vector3d& translation);

/// `motion` applied in double and rounded once.
Cloud moved(const Cloud& cloud, const Eigen::Isometry3d& motion);

/// Root mean square distance between where two transforms put the points.
double rmsDifference(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Cloud& points);

/// Root mean square distance between transform(source) and target.
double rmsResidual(const Eigen::Isometry3d& transform, const Cloud& source, const Cloud& target);

/// Random clouds and motions from a seed.
class Random {
public:
  explicit Random(unsigned seed)
  : generator_(seed)
  {
  }

  double uniform(double low, double high);
  std::size_t count(std::size_t low, std::size_t high);
  Eigen::Vector3d direction();
  Eigen::Matrix3d rotation();
  /// Any rotation, and a translation of up to `reach` along each axis.
  Eigen::Isometry3d motion(double reach);
  /// Points within `half_extents` of `centre`.
  Cloud cloud(std::size_t n, const Eigen::Vector3d& half_extents, const Eigen::Vector3d& centre);
  Cloud cloud(std::size_t n) { return cloud(n, {10, 6, 3}, {1, -2, 3}); }
  /// Unit vectors.
  Cloud directions(std::size_t n);

  std::mt19937& generator() { return generator_; }

private:
  std::mt19937 generator_;
};

/// Points a unit apart, so that small motions leave each nearest to its own.
Cloud lattice(std::size_t n);

/// Coordinates rounded to multiples of 2^-10, so that differences between points within +-16 are exact in float32 and
/// what remains of an error is the device's.
Cloud snapped(const Cloud& cloud);

} // namespace pcl_gpu_icp::test
