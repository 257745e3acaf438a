#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/device_share.h>
#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

namespace pcl_gpu_icp {

/// Matches that agree on a pose which is none.
constexpr std::size_t support_by_chance = 10;

/// Points of two clouds whose surroundings are alike, and the poses that many of them agree on: what clouds have in
/// common shows in them, however small a part of each it is.
class FeatureMatches {
public:
  /// Of the clouds about their pivots, thinned.
  FeatureMatches(const Device& device,
                 const std::vector<PlacedPoint>& source,
                 const std::vector<PlacedPoint>& target,
                 const std::shared_ptr<DeviceShare>& share);

  /// Those that most matches agree on first, each far from those before it.
  std::vector<RigidTransform> poses(std::size_t most) const;

  /// How many matches the pose puts on each other, normals along normals.
  std::size_t support(const RigidTransform& pose) const;

  /// The pose of least squares of the matches that it puts on each other, more and more closely; as it is where they
  /// are few.
  RigidTransform fitted(const RigidTransform& pose) const;

private:
  /// A place and the surface's normal there, of either sign.
  struct SurfacePoint {
    std::array<double, 3> place, normal;
  };
  struct Match {
    SurfacePoint source, target;
  };

  static constexpr double agreeing_voxels = 3;

  /// \param near in voxels
  std::vector<Match> agreeing(const RigidTransform& pose, double near = agreeing_voxels) const;
  bool areCompatible(const Match& a, const Match& b) const;

  double voxel_ = 0;
  std::array<double, 3> centre_{}; ///< of the source
  std::vector<Match> matches_;
};

} // namespace pcl_gpu_icp
