#pragma once

#include "two_way_score.h"

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/device_lane.h>
#include <pcl_gpu_icp/matcher.h>
#include <pcl_gpu_icp/motions.h>
#include <pcl_gpu_icp/normal_estimator.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <array>
#include <memory>
#include <vector>

namespace pcl_gpu_icp {

/// Two clouds, each about a pivot of its own.
struct PlacedPair {
  PlacedPair(const Points& source, const Points& target);

  /// Whether there is a pose to search for.
  bool hasEnough() const;

  RigidTransform aboutPivots(const RigidTransform& pose) const;
  RigidTransform betweenClouds(const RigidTransform& pose) const;

  std::array<double, 3> source_pivot, target_pivot;
  std::vector<PlacedPoint> source_points, target_points;
};

/// Of the rotation between two poses, in radians.
double angleBetween(const RigidTransform& a, const RigidTransform& b);

/// Whether increments may be to planes: normals of a flat cloud say nothing of its outline.
bool hasSurfaces(const ThinPair& pair, Motions motions);

/// A thinned target on a device, and its normals where increments are to planes.
class ThinTarget {
public:
  ThinTarget(const Device& device, const ThinPair& pair, bool to_planes, const std::shared_ptr<DeviceShare>& share);

  /// With the source of the pair.
  std::unique_ptr<Matcher> matcherOn(const DeviceLane& lane, const ThinPair& pair) const;

private:
  std::shared_ptr<const MatchTarget> tree_;
  NormalEstimator::Normals normals_;
};

} // namespace pcl_gpu_icp
