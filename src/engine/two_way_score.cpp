#include "two_way_score.h"

#include "search/voxels.h"

namespace pcl_gpu_icp {

ThinPair::ThinPair(const std::vector<PlacedPoint>& source_points,
                   const std::vector<PlacedPoint>& target_points,
                   double size)
: source(search::voxelMeans(source_points, size))
, target(search::voxelMeans(target_points, size))
, voxel(size)
{
}

double scoreOf(const Matches& matches, double scale)
{
  return matches.increment.pairs > 0 ? 1 - matches.mean_squared_residual / (scale * scale) : 0;
}

TwoWayScore::TwoWayScore(const Device& device,
                         const ThinPair& pair,
                         double scale,
                         const std::shared_ptr<DeviceShare>& share)
: pair_(&pair)
, scale_(scale)
, forward_(device, CorrespondenceSearch::DeviceKdTree, Precision::Float)
, backward_(device, CorrespondenceSearch::DeviceKdTree, Precision::Float)
, box_(pair.source)
{
  forward_.setTarget(forward_.makeTarget(viewOf(pair.target)));
  forward_.setSource(viewOf(pair.source));
  backward_.setTarget(backward_.makeTarget(viewOf(pair.source)));
  for (Matcher* matcher : {&forward_, &backward_}) {
    matcher->setShare(share);
    matcher->setLoss({LossFunction::GemanMcClure, scale});
    matcher->setSteps(1);
  }
}

double TwoWayScore::operator()(const RigidTransform& pose)
{
  const RigidTransform back = inverse(pose);
  std::vector<PlacedPoint> in_view;
  for (const PlacedPoint& point : pair_->target) {
    if (box_.holds(back(point.xyz[0], point.xyz[1], point.xyz[2]), scale_))
      in_view.push_back(point);
  }
  backward_.setSource(viewOf(in_view));
  return scoreOf(forward_.match(pose, everywhere), scale_) * scoreOf(backward_.match(back, everywhere), scale_);
}

} // namespace pcl_gpu_icp
