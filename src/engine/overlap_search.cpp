#include <pcl_gpu_icp/overlap_search.h>

#include "geometry/vector.h"
#include "search/voxels.h"
#include "thin_target.h"

#include <pcl_gpu_icp/icp_loop.h>

#include <cmath>
#include <map>

namespace pcl_gpu_icp {

namespace {

/// A way from coarse to fine: the first voxels are this part of the radius, the loss this many voxels wide.
struct Way {
  double first, loss;
};
constexpr Way ways[] = {{1.0 / 6, 1}, {1.0 / 6, 2}, {1.0 / 10, 1}, {1.0 / 6, 4}, {1.0 / 4, 2}, {1.0 / 16, 1}};

/// Both clouds at a size of voxels, on a device.
struct Level {
  Level(const Device& device, ThinPair thinned, Motions motions, const std::shared_ptr<DeviceShare>& share)
  : pair(std::move(thinned))
  , target(device, pair, hasSurfaces(pair, motions), share)
  , matcher(target.matcherOn(DeviceLane(device, share, nullptr), pair))
  {
    matcher->setMotions(motions);
  }

  ThinPair pair;
  ThinTarget target;
  std::unique_ptr<Matcher> matcher;
};

/// Brings the pose nearer, until an iteration moves the source by hardly any part of a voxel.
RigidTransform refined(Level& level, const RigidTransform& start, double scale, const Lever& lever)
{
  constexpr int iterations = 20;
  constexpr double hardly = 1e-3;
  level.matcher->setLoss({LossFunction::GemanMcClure, scale});
  RigidTransform pose = start;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const RigidTransform next = compose(level.matcher->match(pose, everywhere).increment.transform, pose);
    const auto& at = lever.centre;
    const double moved =
        distance(next(at[0], at[1], at[2]), pose(at[0], at[1], at[2])) + angleBetween(next, pose) * lever.length;
    pose = next;
    if (moved < hardly * level.pair.voxel)
      break;
  }
  return pose;
}

} // namespace

OverlapSearch::OverlapSearch(const Device& device)
: device_(device)
{
}

OverlapSearchResult OverlapSearch::search(const Points& source, const Points& target, const RigidTransform& guess) const
{
  constexpr std::size_t finest_points = 1 << 14;
  constexpr double coarser = 1.5;
  OverlapSearchResult best;
  best.transform = guess;
  const PlacedPair placed(source, target);
  if (!placed.hasEnough())
    return best;
  const double finest = search::voxelSizeFor(placed.source_points, finest_points);
  if (!(finest > 0))
    return best;
  Level last(device_, ThinPair(placed.source_points, placed.target_points, finest), motions_, share_);
  if (last.pair.source.size() < 4 || last.pair.target.size() < 4)
    return best;
  const Lever lever = leverOf(viewOf(last.pair.source));
  std::map<double, std::unique_ptr<Level>> levels;
  double best_fit = -1;
  for (const Way& way : ways) {
    RigidTransform pose = placed.aboutPivots(guess);
    double size = way.first * lever.length;
    while (size > coarser * finest) {
      auto& level = levels[size];
      if (!level)
        level = std::make_unique<Level>(device_, ThinPair(last.pair.source, last.pair.target, size), motions_, share_);
      pose = refined(*level, pose, way.loss * size, lever);
      size /= 2;
    }
    pose = placed.betweenClouds(refined(last, pose, finest, lever));
    const Quality quality = qualityOf(source, target, guess, pose);
    ++best.ways;
    const double fit = fitOf(quality);
    if (fit > best_fit) {
      best_fit = fit;
      best.transform = pose;
      best.quality = quality;
    }
    if (judge(quality).verdict == Verdict::Good)
      break;
  }
  return best;
}

} // namespace pcl_gpu_icp
