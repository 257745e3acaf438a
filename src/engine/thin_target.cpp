#include "thin_target.h"

#include "search/box_tree.h"

#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp {

PlacedPair::PlacedPair(const Points& source, const Points& target)
: source_pivot(search::pivotOf(source))
, target_pivot(search::pivotOf(target))
, source_points(search::finitePoints(source, source_pivot, effectiveThreads(0)))
, target_points(search::finitePoints(target, target_pivot, effectiveThreads(0)))
{
}

bool PlacedPair::hasEnough() const
{
  constexpr std::size_t fewest_points = 10;
  return source_points.size() >= fewest_points && target_points.size() >= fewest_points;
}

RigidTransform PlacedPair::aboutPivots(const RigidTransform& pose) const
{
  return recentred(pose, source_pivot, target_pivot);
}

RigidTransform PlacedPair::betweenClouds(const RigidTransform& pose) const
{
  return recentred(pose,
                   {-source_pivot[0], -source_pivot[1], -source_pivot[2]},
                   {-target_pivot[0], -target_pivot[1], -target_pivot[2]});
}

double angleBetween(const RigidTransform& a, const RigidTransform& b)
{
  double trace = 0;
  for (int i = 0; i < 9; ++i)
    trace += a.rotation[i] * b.rotation[i];
  return std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0));
}

bool hasSurfaces(const ThinPair& pair, Motions motions)
{
  return motions != Motions::Planar && Box(pair.target).thickness() > pair.voxel;
}

ThinTarget::ThinTarget(const Device& device,
                       const ThinPair& pair,
                       bool to_planes,
                       const std::shared_ptr<DeviceShare>& share)
: tree_(Matcher(device, CorrespondenceSearch::DeviceKdTree, Precision::Float).makeTarget(viewOf(pair.target)))
{
  if (!to_planes)
    return;
  NormalEstimator estimator(device, Precision::Float);
  estimator.setShare(share);
  normals_ = estimator.estimate(viewOf(pair.target));
}

std::unique_ptr<Matcher> ThinTarget::matcherOn(const DeviceLane& lane, const ThinPair& pair) const
{
  auto made = std::make_unique<Matcher>(lane.device, CorrespondenceSearch::DeviceKdTree, Precision::Float);
  made->setShare(lane.share);
  made->setNumberOfThreads(1);
  made->setTarget(tree_);
  if (!normals_.empty())
    made->setTargetNormals({normals_.data(), normals_.size(), sizeof(normals_[0])});
  made->setSource(viewOf(pair.source));
  return made;
}

} // namespace pcl_gpu_icp
