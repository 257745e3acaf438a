#include "two_way_score.h"

#include "search/bulk.h"
#include "search/voxels.h"

#include <algorithm>
#include <functional>

namespace pcl_gpu_icp {

Box::Box(const std::vector<PlacedPoint>& points)
{
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  const search::Bulk bulk(viewOf(points));
  for (const PlacedPoint& point : points)
    if (bulk.holds(point.xyz))
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min<double>(low[axis], point.xyz[axis]);
        high[axis] = std::max<double>(high[axis], point.xyz[axis]);
      }
}

double Box::thickness() const { return std::min({high[0] - low[0], high[1] - low[1], high[2] - low[2]}); }

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
{
  forward_.setTarget(forward_.makeTarget(viewOf(pair.target)));
  forward_.setSource(viewOf(pair.source));
  backward_.setTarget(backward_.makeTarget(viewOf(pair.source)));
  for (Matcher* matcher : {&forward_, &backward_}) {
    matcher->setShare(share);
    matcher->setLoss({LossFunction::GemanMcClure, scale});
  }
  const Box box(pair.source);
  for (int axis = 0; axis < 3; ++axis) {
    low_[axis] = box.low[axis] - scale;
    high_[axis] = box.high[axis] + scale;
  }
}

double TwoWayScore::operator()(const RigidTransform& pose)
{
  const RigidTransform back = inverse(pose);
  std::vector<PlacedPoint> in_view;
  for (const PlacedPoint& point : pair_->target) {
    const auto at = back(point.xyz[0], point.xyz[1], point.xyz[2]);
    if (std::equal(at.begin(), at.end(), low_.begin(), std::greater<>()) &&
        std::equal(at.begin(), at.end(), high_.begin(), std::less<>()))
      in_view.push_back(point);
  }
  backward_.setSource(viewOf(in_view));
  return scoreOf(forward_.match(pose, everywhere), scale_) * scoreOf(backward_.match(back, everywhere), scale_);
}

} // namespace pcl_gpu_icp
