#include <pcl_gpu_icp/pose_search.h>

#include "pose_starts.h"
#include "search/box_tree.h"
#include "search/bulk.h"
#include "search/voxels.h"
#include "two_way_score.h"

#include <pcl_gpu_icp/batch_lanes.h>
#include <pcl_gpu_icp/matcher.h>
#include <pcl_gpu_icp/normal_estimator.h>
#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace pcl_gpu_icp {

namespace {

constexpr std::size_t fewest_points = 10, fewest_voxels = 4;

std::array<double, 3> centroidOf(const std::vector<PlacedPoint>& points)
{
  const search::Bulk bulk(viewOf(points));
  std::array<double, 3> sum{};
  double n = 0;
  for (const PlacedPoint& point : points)
    if (bulk.holds(point.xyz)) {
      for (int axis = 0; axis < 3; ++axis)
        sum[axis] += point.xyz[axis];
      ++n;
    }
  return {sum[0] / n, sum[1] / n, sum[2] / n};
}

double distance(const std::array<double, 3>& a, const std::array<double, 3>& b)
{
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Of the rotation between two poses, in radians.
double angleBetween(const RigidTransform& a, const RigidTransform& b)
{
  double trace = 0;
  for (int i = 0; i < 9; ++i)
    trace += a.rotation[i] * b.rotation[i];
  return std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0));
}

/// How the poses of a round are brought nearer.
struct Round {
  int iterations;
  double scale; ///< of the loss, in voxels
  bool to_planes;
};

/// A target on a device, and its normals where increments are to planes.
struct RoundTarget {
  RoundTarget(const Device& device, const ThinPair& pair, bool to_planes, const std::shared_ptr<DeviceShare>& share)
  : tree(Matcher(device, CorrespondenceSearch::DeviceKdTree, Precision::Float).makeTarget(viewOf(pair.target)))
  {
    if (!to_planes)
      return;
    NormalEstimator estimator(device, Precision::Float);
    estimator.setShare(share);
    normals = estimator.estimate(viewOf(pair.target));
  }

  /// With the source of the pair.
  std::unique_ptr<Matcher> matcherOn(const DeviceLane& lane, const ThinPair& pair) const
  {
    auto made = std::make_unique<Matcher>(lane.device, CorrespondenceSearch::DeviceKdTree, Precision::Float);
    made->setShare(lane.share);
    made->setNumberOfThreads(1);
    made->setTarget(tree);
    if (!normals.empty())
      made->setTargetNormals({normals.data(), normals.size(), sizeof(normals[0])});
    made->setSource(viewOf(pair.source));
    return made;
  }

  std::shared_ptr<const MatchTarget> tree;
  NormalEstimator::Normals normals;
};

void sortByScore(std::vector<PoseCandidate>& candidates)
{
  std::stable_sort(candidates.begin(), candidates.end(), [](const PoseCandidate& a, const PoseCandidate& b) {
    return a.score > b.score;
  });
}

} // namespace

bool PoseSearchResult::isAmbiguous() const
{
  constexpr double nearly = 0.9;
  return poses.size() > 1 && poses[1].score > nearly * poses[0].score;
}

PoseSearch::PoseSearch(const Device& device)
: device_(device)
{
}

PoseSearchResult PoseSearch::search(const Points& source, const Points& target, const RigidTransform& guess) const
{
  const unsigned threads = effectiveThreads(0);
  const auto source_pivot = search::pivotOf(source), target_pivot = search::pivotOf(target);
  const auto source_points = search::finitePoints(source, source_pivot, threads);
  const auto target_points = search::finitePoints(target, target_pivot, threads);
  PoseSearchResult result;
  if (source_points.size() < fewest_points || target_points.size() < fewest_points)
    return result;

  constexpr std::size_t coarse_points = 500, fine_points = 4000;
  const double coarse_size = search::voxelSizeFor(source_points, coarse_points);
  const double fine_size = search::voxelSizeFor(source_points, fine_points);
  if (!(coarse_size > 0 && fine_size > 0))
    return result;
  const ThinPair coarse(source_points, target_points, coarse_size), fine(source_points, target_points, fine_size);
  for (const auto* thinned : {&coarse.source, &coarse.target, &fine.source, &fine.target})
    if (thinned->size() < fewest_voxels)
      return result;

  // The starts, between the clouds about their pivots.
  const RigidTransform start = recentred(guess, source_pivot, target_pivot);
  const auto from = centroidOf(coarse.source), onto = centroidOf(coarse.target);
  std::vector<PoseCandidate> candidates{{start, 0}};
  for (const auto& turn : turnsOf(motions_)) {
    RigidTransform turned;
    turned.rotation = compose({turn, {}}, start).rotation;
    const auto add = [&](const std::array<double, 3>& point, const std::array<double, 3>& image) {
      RigidTransform pose = turned;
      const auto moved = turned(point[0], point[1], point[2]);
      for (int axis = 0; axis < 3; ++axis)
        pose.translation[axis] = image[axis] - moved[axis];
      const RigidTransform motion =
          restricted(compose(pose, inverse(start)), motions_, start(from[0], from[1], from[2]));
      candidates.push_back({compose(motion, start), 0});
    };
    add(from, onto);
    const std::array<double, 3> origin{-source_pivot[0], -source_pivot[1], -source_pivot[2]};
    const std::array<double, 3> place = start(origin[0], origin[1], origin[2]);
    if (distance(turned(from[0] - origin[0], from[1] - origin[1], from[2] - origin[2]),
                 {onto[0] - place[0], onto[1] - place[1], onto[2] - place[2]}) > 2 * coarse.voxel)
      add(origin, place);
  }
  result.starts = candidates.size();

  constexpr std::size_t of_a_group = 16;
  std::size_t groups_done = 0, groups = 0;
  const auto groups_of = [](std::size_t count) { return (count + of_a_group - 1) / of_a_group; };
  const auto bringNearer = [&](const ThinPair& pair, const Round& round, std::size_t groups_after) {
    groups = groups_done + groups_of(candidates.size()) + groups_after;
    const RoundTarget round_target(device_, pair, round.to_planes, share_);
    const auto run = [&](DeviceLane& lane, std::size_t first) {
      if (!lane.matcher)
        lane.matcher = round_target.matcherOn(lane, pair);
      Matcher& matcher = *lane.matcher;
      const double scale = round.scale * pair.voxel;
      matcher.setLoss({LossFunction::GemanMcClure, scale});
      matcher.setMotions(motions_);
      for (std::size_t i = first; i < std::min(first + of_a_group, candidates.size()); ++i) {
        RigidTransform& pose = candidates[i].transform;
        for (int iteration = 0; iteration < round.iterations; ++iteration)
          pose = compose(matcher.match(pose, everywhere).increment.transform, pose);
        candidates[i].score = scoreOf(matcher.match(pose, everywhere), scale);
      }
    };
    const auto tell = [&] {
      ++groups_done;
      if (progress_)
        progress_(groups_done, groups);
    };
    if (share_) {
      DeviceLane lane(device_, share_, nullptr);
      for (std::size_t first = 0; first < candidates.size(); first += of_a_group) {
        run(lane, first);
        tell();
      }
    }
    else {
      BatchLanes lanes;
      for (std::size_t first = 0; first < candidates.size(); first += of_a_group)
        lanes.add(pair.source.size() + pair.target.size(), [&, first](DeviceLane& lane) {
          run(lane, first);
          return BatchResult();
        });
      BatchSettings settings;
      settings.lanes = lanes_;
      for (const BatchResult& done : lanes.run({device_}, settings, [&](std::size_t, const BatchResult&) { tell(); }))
        if (done.alignment.error)
          std::rethrow_exception(done.alignment.error);
    }
    sortByScore(candidates);
  };
  const auto keep = [&](std::size_t most, bool distinct) {
    constexpr double near_angle = 0.17; // 10 degrees
    std::vector<PoseCandidate> kept;
    for (const PoseCandidate& candidate : candidates) {
      const auto at = candidate.transform(from[0], from[1], from[2]);
      const bool known = distinct && std::any_of(kept.begin(), kept.end(), [&](const PoseCandidate& other) {
                           return angleBetween(candidate.transform, other.transform) < near_angle &&
                                  distance(at, other.transform(from[0], from[1], from[2])) < 3 * coarse.voxel;
                         });
      if (!known && kept.size() < most)
        kept.push_back(candidate);
    }
    candidates = std::move(kept);
  };

  constexpr std::size_t after_first = 200, after_second = 40, after_third = 8;
  bringNearer(coarse, {5, 4, false}, groups_of(after_first) + groups_of(after_second));
  keep(after_first, false);
  bringNearer(coarse, {10, 2, false}, groups_of(after_second));
  keep(after_second, true);
  // Normals of a flat cloud say nothing of its outline.
  const bool has_surfaces = motions_ != Motions::Planar && Box(fine.target).thickness() > fine.voxel;
  bringNearer(fine, {15, 4, has_surfaces}, 0);

  TwoWayScore score(device_, fine, 4 * fine.voxel, share_);
  for (PoseCandidate& candidate : candidates)
    candidate.score = score(candidate.transform);
  sortByScore(candidates);
  keep(after_third, true);
  candidates.erase(
      std::remove_if(candidates.begin(), candidates.end(), [](const PoseCandidate& c) { return !(c.score > 0); }),
      candidates.end());
  for (PoseCandidate& candidate : candidates)
    candidate.transform = recentred(candidate.transform,
                                    {-source_pivot[0], -source_pivot[1], -source_pivot[2]},
                                    {-target_pivot[0], -target_pivot[1], -target_pivot[2]});
  result.poses = std::move(candidates);
  return result;
}

} // namespace pcl_gpu_icp
