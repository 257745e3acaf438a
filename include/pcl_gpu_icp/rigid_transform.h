#pragma once

#include <pcl_gpu_icp/export.h>

#include <array>

namespace pcl_gpu_icp {

/// A rigid transform x -> R x + t in double precision. R is row-major, t in the unit of the points.
struct RigidTransform {
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::array<double, 3> translation{0, 0, 0};

  std::array<double, 3> operator()(double x, double y, double z) const
  {
    const auto& r = rotation;
    return {r[0] * x + r[1] * y + r[2] * z + translation[0],
            r[3] * x + r[4] * y + r[5] * z + translation[1],
            r[6] * x + r[7] * y + r[8] * z + translation[2]};
  }
};

/// first, then second: x -> second(first(x)).
PCL_GPU_ICP_API RigidTransform compose(const RigidTransform& second, const RigidTransform& first);

/// Also of a transform that scales, as a caller's estimator may.
PCL_GPU_ICP_API RigidTransform inverse(const RigidTransform& transform);

/// How far R R^T of a guess may be from the identity, entry by entry: what a rotation written with three decimals is
/// off at most (1.74e-3).
constexpr double rigid_tolerance = 2e-3;

/// Whether all is finite and R is a rotation but for rigid_tolerance: neither scaled nor mirrored.
PCL_GPU_ICP_API bool isRigid(const RigidTransform& transform);

/// The rotation nearest to a transform that isRigid(), to double's last digits, with the translation that leaves
/// `anchor` where it was mapped to.
PCL_GPU_ICP_API RigidTransform nearestRigid(const RigidTransform& transform, const std::array<double, 3>& anchor);

/// The same motion written about another origin: maps x - from to y - to where `transform` maps x to y.
PCL_GPU_ICP_API RigidTransform recentred(const RigidTransform& transform,
                                         const std::array<double, 3>& from,
                                         const std::array<double, 3>& to);

/// The value that a narrower scalar holds. Volatile, because GCC 12.2 leaves the double -> float -> double conversion
/// out where it vectorises it at -O2.
template <typename Scalar>
double rounded(double value)
{
  const volatile Scalar narrow = static_cast<Scalar>(value);
  return narrow;
}

/// The transform as it is handed out in a narrower scalar: R is rounded first and t is derived from the rounded R so
/// that `anchor` (the source's pivot) still maps where it should. Rounding R and t apart would be off by R's rounding
/// times the distance from the origin: 2 cm at 500 km.
template <typename Scalar>
RigidTransform rounded(const RigidTransform& transform, const std::array<double, 3>& anchor)
{
  RigidTransform result;
  for (int i = 0; i < 9; ++i)
    result.rotation[i] = rounded<Scalar>(transform.rotation[i]);
  const auto image = transform(anchor[0], anchor[1], anchor[2]);
  const auto rotated = result(anchor[0], anchor[1], anchor[2]);
  for (int i = 0; i < 3; ++i)
    result.translation[i] = rounded<Scalar>(image[i] - rotated[i]);
  return result;
}

} // namespace pcl_gpu_icp
