#pragma once

#include <pcl_gpu_icp/export.h>
#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <array>
#include <optional>

namespace pcl_gpu_icp {

/// What the ICP loop asks of its surroundings. Transforms map source to target coordinates.
class PCL_GPU_ICP_API IcpSteps {
public:
  virtual ~IcpSteps() = default;

  /// Finds the correspondences of the source at `pose`. False: too few to go on.
  virtual bool match(const RigidTransform& pose) = 0;

  /// What ICP makes smaller with each iteration, at the pose matched last.
  virtual double error() const = 0;

  /// The rigid transform that takes the matched source points at `pose` onto their targets.
  virtual RigidTransform estimateIncrement(const RigidTransform& pose) = 0;

  /// Whether to stop, after `increment` led to `pose`.
  virtual bool finished(const RigidTransform& increment, const RigidTransform& pose) = 0;
};

/// Makes a rotation comparable with a translation: by how far it moves a point `length` from `centre`.
struct Lever {
  std::array<double, 3> centre{};
  double length = 0;
};

/// The centroid of the points that take part, and their root mean square distance from it; a few far from all others do
/// not count.
PCL_GPU_ICP_API Lever leverOf(const Points& points);

/// How far apart neighbours are, about, on a surface of so many points with that root mean square radius.
PCL_GPU_ICP_API double surfaceSpacing(double radius, std::size_t points);

/// The same of the points that take part.
PCL_GPU_ICP_API double surfaceSpacing(const Points& points);

/// Iterative closest point (Besl and McKay 1992): match, estimate, move, until finished.
/// \param acceleration of the source: each pose is then an extrapolation of the last steps (Anderson acceleration),
/// which is taken back where the error rises
/// \return the accumulated transform
PCL_GPU_ICP_API RigidTransform iterate(IcpSteps& steps,
                                       const RigidTransform& guess,
                                       const std::optional<Lever>& acceleration = std::nullopt);

} // namespace pcl_gpu_icp
