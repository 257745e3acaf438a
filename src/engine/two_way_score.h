#pragma once

#include "box.h"

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/device_share.h>
#include <pcl_gpu_icp/matcher.h>
#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <limits>
#include <memory>
#include <vector>

namespace pcl_gpu_icp {

constexpr float everywhere = std::numeric_limits<float>::infinity();

/// Both clouds about their pivots, thinned by voxels of one size.
struct ThinPair {
  ThinPair(const std::vector<PlacedPoint>& source_points, const std::vector<PlacedPoint>& target_points, double size);

  std::vector<PlacedPoint> source, target;
  double voxel;
};

/// 1 where every point is on the other cloud, 0 where all are far from it.
/// \param scale of the Geman-McClure loss that they were matched with
double scoreOf(const Matches& matches, double scale);

/// How well a pose puts each cloud on the other: what the source would show of the target must be there as well.
class TwoWayScore {
public:
  TwoWayScore(const Device& device, const ThinPair& pair, double scale, const std::shared_ptr<DeviceShare>& share);

  double operator()(const RigidTransform& pose);

private:
  const ThinPair* pair_;
  double scale_;
  Matcher forward_, backward_;
  Box box_; ///< around the source
};

} // namespace pcl_gpu_icp
