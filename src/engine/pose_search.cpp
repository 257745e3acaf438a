#include <pcl_gpu_icp/pose_search.h>

#include "pose_starts.h"
#include "qualities.h"
#include "search/bulk.h"
#include "search/voxels.h"
#include "thin_target.h"
#include "two_way_score.h"

#include <pcl_gpu_icp/batch_lanes.h>
#include <pcl_gpu_icp/matcher.h>

#include <algorithm>
#include <limits>
#include <memory>

namespace pcl_gpu_icp {

namespace {

constexpr std::size_t fewest_voxels = 4;

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

/// How the poses of a round are brought nearer.
struct Round {
  int iterations;
  double scale; ///< of the loss, in voxels
  bool to_planes;
};

struct Candidate {
  RigidTransform transform; ///< between the clouds about their pivots
  double score = 0;
  bool from_guess = false;
};

void sortByScore(std::vector<Candidate>& candidates)
{
  std::stable_sort(
      candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
}

} // namespace

PoseSearch::PoseSearch(const Device& device)
: device_(device)
{
}

PoseSearchResult PoseSearch::search(const Points& source, const Points& target, const RigidTransform& guess) const
{
  const PlacedPair placed(source, target);
  PoseSearchResult result;
  if (!placed.hasEnough())
    return result;
  const auto& source_points = placed.source_points;
  const auto& target_points = placed.target_points;
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
  const RigidTransform start = placed.aboutPivots(guess);
  const auto from = centroidOf(coarse.source), onto = centroidOf(coarse.target);
  std::vector<Candidate> candidates{{start}};
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
      candidates.push_back({compose(motion, start)});
    };
    add(from, onto);
    const std::array<double, 3> origin{-placed.source_pivot[0], -placed.source_pivot[1], -placed.source_pivot[2]};
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
    const ThinTarget thin_target(device_, pair, round.to_planes, share_);
    const auto run = [&](DeviceLane& lane, std::size_t first) {
      if (!lane.matcher)
        lane.matcher = thin_target.matcherOn(lane, pair);
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
    std::vector<Candidate> kept;
    for (const Candidate& candidate : candidates) {
      const auto at = candidate.transform(from[0], from[1], from[2]);
      const auto known =
          distinct ? std::find_if(kept.begin(),
                                  kept.end(),
                                  [&](const Candidate& other) {
                                    return angleBetween(candidate.transform, other.transform) < near_angle &&
                                           distance(at, other.transform(from[0], from[1], from[2])) < 3 * coarse.voxel;
                                  })
                   : kept.end();
      if (known != kept.end())
        known->from_guess |= candidate.from_guess;
      else if (kept.size() < most || candidate.from_guess)
        kept.push_back(candidate);
    }
    candidates = std::move(kept);
  };

  constexpr std::size_t after_first = 200, after_second = 40, after_third = 8;
  bringNearer(coarse, {5, 4, false}, groups_of(after_first) + groups_of(after_second) + groups_of(after_third));
  keep(after_first, false);
  bringNearer(coarse, {10, 2, false}, groups_of(after_second) + groups_of(after_third));
  keep(after_second, true);
  candidates.push_back({start, 0, true}); // from where steps on coarse clouds may have led away
  const bool to_planes = hasSurfaces(fine, motions_);
  TwoWayScore score(device_, fine, 4 * fine.voxel, share_);
  const auto rank = [&] {
    for (Candidate& candidate : candidates)
      candidate.score = score(candidate.transform);
    sortByScore(candidates);
    keep(after_third, true);
  };
  bringNearer(fine, {15, 4, to_planes}, groups_of(after_third));
  rank();
  bringNearer(fine, {10, 1, to_planes}, 0);
  rank();
  candidates.erase(
      std::remove_if(candidates.begin(), candidates.end(), [](const Candidate& c) { return !(c.score > 0); }),
      candidates.end());
  std::vector<RigidTransform> poses(candidates.size());
  std::transform(candidates.begin(), candidates.end(), poses.begin(), [&placed](const Candidate& candidate) {
    return placed.betweenClouds(candidate.transform);
  });
  const std::vector<Quality> qualities = qualitiesOf(source, target, guess, poses);
  for (std::size_t i = 0; i < poses.size(); ++i)
    result.poses.push_back({poses[i], candidates[i].score, qualities[i]});
  return result;
}

} // namespace pcl_gpu_icp
