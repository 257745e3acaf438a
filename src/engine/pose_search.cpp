#include <pcl_gpu_icp/pose_search.h>

#include "feature_matches.h"
#include "pose_starts.h"
#include "qualities.h"
#include "search/bulk.h"
#include "search/voxels.h"
#include "thin_target.h"
#include "two_way_score.h"

#include <pcl_gpu_icp/batch_lanes.h>
#include <pcl_gpu_icp/matcher.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>

namespace pcl_gpu_icp {

namespace {

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

struct Candidate {
  RigidTransform transform; ///< between the clouds about their pivots
  double score = 0;
  bool from_guess = false;
  std::size_t support = 0;
};
using Candidates = std::vector<Candidate>;

template <typename Rank>
void sortBy(const Rank& rankOf, Candidates& candidates)
{
  std::stable_sort(candidates.begin(), candidates.end(), [&rankOf](const Candidate& a, const Candidate& b) {
    return rankOf(a) > rankOf(b);
  });
}

/// How poses are brought nearer.
struct Round {
  int iterations;
  double scale; ///< of the loss, in voxels
};

/// Counts groups of starts that are done, of no more than it began with.
class Progress {
public:
  Progress(std::function<void(std::size_t, std::size_t)> tell, std::size_t groups)
  : tell_(std::move(tell))
  , groups_(groups)
  {
  }

  /// From here on there are so many.
  void expect(std::size_t groups) { groups_ = std::min(groups_, done_ + groups); }

  void add()
  {
    ++done_;
    if (tell_)
      tell_(done_, std::max(groups_, done_));
  }

private:
  std::function<void(std::size_t, std::size_t)> tell_;
  std::size_t groups_, done_ = 0;
};

/// A thinned pair on a device, and how its poses are brought nearer.
class Level {
public:
  Level(const Device& device,
        const ThinPair& pair,
        Motions motions,
        bool to_planes,
        unsigned lanes,
        const std::shared_ptr<DeviceShare>& share)
  : device_(device)
  , pair_(pair)
  , motions_(motions)
  , target_(device, pair, to_planes, share)
  , lanes_(lanes)
  , share_(share)
  {
  }

  /// And scores them by what the source has of the target.
  void bringNearer(Candidates& candidates, const Round& round, Progress& progress) const
  {
    const auto run = [&](DeviceLane& lane, std::size_t first) {
      if (!lane.matcher)
        lane.matcher = target_.matcherOn(lane, pair_);
      Matcher& matcher = *lane.matcher;
      const double scale = round.scale * pair_.voxel;
      matcher.setLoss({LossFunction::GemanMcClure, scale});
      matcher.setMotions(motions_);
      for (std::size_t i = first; i < std::min(first + of_a_group, candidates.size()); ++i) {
        RigidTransform& pose = candidates[i].transform;
        for (int iteration = 0; iteration < round.iterations; ++iteration)
          pose = compose(matcher.match(pose, everywhere).increment.transform, pose);
        candidates[i].score = scoreOf(matcher.match(pose, everywhere), scale);
      }
    };
    if (share_) {
      DeviceLane lane(device_, share_, nullptr);
      for (std::size_t first = 0; first < candidates.size(); first += of_a_group) {
        run(lane, first);
        progress.add();
      }
      return;
    }
    BatchLanes lanes;
    for (std::size_t first = 0; first < candidates.size(); first += of_a_group)
      lanes.add(pair_.source.size() + pair_.target.size(), [&, first](DeviceLane& lane) {
        run(lane, first);
        return BatchResult();
      });
    BatchSettings settings;
    settings.lanes = lanes_;
    for (const BatchResult& done :
         lanes.run({device_}, settings, [&](std::size_t, const BatchResult&) { progress.add(); }))
      if (done.alignment.error)
        std::rethrow_exception(done.alignment.error);
  }

  static std::size_t groupsOf(std::size_t candidates) { return (candidates + of_a_group - 1) / of_a_group; }

private:
  static constexpr std::size_t of_a_group = 8;

  Device device_;
  const ThinPair& pair_;
  Motions motions_;
  ThinTarget target_;
  unsigned lanes_;
  std::shared_ptr<DeviceShare> share_;
};

/// Keeps the first ones.
void keep(Candidates& candidates, std::size_t most)
{
  std::size_t count = 0;
  candidates.erase(std::remove_if(candidates.begin(),
                                  candidates.end(),
                                  [&](const Candidate& each) { return ++count > most && !each.from_guess; }),
                   candidates.end());
}

/// Keeps the first of those that are near each other.
void keepDistinct(Candidates& candidates, const std::array<double, 3>& place, double near)
{
  constexpr double near_angle = 0.17; // 10 degrees
  Candidates kept;
  for (const Candidate& candidate : candidates) {
    const auto at = candidate.transform(place[0], place[1], place[2]);
    const auto known = std::find_if(kept.begin(), kept.end(), [&](const Candidate& other) {
      return angleBetween(candidate.transform, other.transform) < near_angle &&
             distance(at, other.transform(place[0], place[1], place[2])) < near;
    });
    if (known == kept.end())
      kept.push_back(candidate);
    else
      known->from_guess |= candidate.from_guess;
  }
  candidates = std::move(kept);
}

// As many candidates as go on.
constexpr std::size_t by_features = 16, after_first = 200, after_second = 40, after_third = 8;

/// Whether the best, and no other, has what features say.
bool areDecided(const Candidates& candidates)
{
  constexpr std::size_t enough = 20, times_more = 2;
  if (candidates.empty() || candidates[0].support < enough)
    return false;
  return std::all_of(candidates.begin() + 1, candidates.end(), [&](const Candidate& other) {
    return times_more * other.support <= candidates[0].support;
  });
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
  constexpr std::size_t coarse_points = 500, fine_points = 4000, fewest_voxels = 4;
  const double coarse_size = search::voxelSizeFor(source_points, coarse_points);
  const double fine_size = search::voxelSizeFor(source_points, fine_points);
  if (!(coarse_size > 0 && fine_size > 0))
    return result;
  const ThinPair coarse(source_points, target_points, coarse_size), fine(source_points, target_points, fine_size);
  for (const auto* thinned : {&coarse.source, &coarse.target, &fine.source, &fine.target})
    if (thinned->size() < fewest_voxels)
      return result;

  // Poses are between the clouds about their pivots.
  const RigidTransform start = placed.aboutPivots(guess);
  const auto from = centroidOf(coarse.source), onto = centroidOf(coarse.target);
  const auto allowed = [&](const RigidTransform& pose) {
    const RigidTransform motion = restricted(compose(pose, inverse(start)), motions_, start(from[0], from[1], from[2]));
    return Candidate{compose(motion, start)};
  };
  Candidates starts{{start, 0, true}};
  for (const auto& turn : turnsOf(motions_)) {
    RigidTransform turned;
    turned.rotation = compose({turn, {}}, start).rotation;
    const auto add = [&](const std::array<double, 3>& point, const std::array<double, 3>& image) {
      RigidTransform pose = turned;
      const auto moved = turned(point[0], point[1], point[2]);
      for (int axis = 0; axis < 3; ++axis)
        pose.translation[axis] = image[axis] - moved[axis];
      starts.push_back(allowed(pose));
    };
    add(from, onto);
    const std::array<double, 3> origin{-placed.source_pivot[0], -placed.source_pivot[1], -placed.source_pivot[2]};
    const std::array<double, 3> place = start(origin[0], origin[1], origin[2]);
    if (distance(turned(from[0] - origin[0], from[1] - origin[1], from[2] - origin[2]),
                 {onto[0] - place[0], onto[1] - place[1], onto[2] - place[2]}) > 2 * coarse.voxel)
      add(origin, place);
  }

  const bool to_planes = hasSurfaces(fine, motions_);
  // The guess goes on wherever it ranks, and may be there twice.
  const std::size_t groups_to_settle = Level::groupsOf(2 * after_third + 2) + 1;
  const std::size_t groups_by_features = Level::groupsOf(by_features + 1) + groups_to_settle;
  const std::size_t groups_of_starts = Level::groupsOf(starts.size()) + Level::groupsOf(after_first + 1) +
                                       Level::groupsOf(after_second + 1) + groups_to_settle;
  Progress progress(progress_, groups_by_features + groups_of_starts);
  const Level finer(device_, fine, motions_, to_planes, lanes_, share_);
  TwoWayScore score(device_, fine, 4 * fine.voxel, share_);
  std::unique_ptr<FeatureMatches> features;
  if (to_planes)
    features = std::make_unique<FeatureMatches>(device_, source_points, target_points, share_);
  const auto measure = [&](Candidate& candidate) {
    candidate.score = score(candidate.transform);
    candidate.support = features ? features->support(candidate.transform) : 0;
  };
  const auto rankOf = [](const Candidate& candidate) {
    constexpr double by_chance = 10; // matches that agree on a pose which is none
    return candidate.score * (by_chance + static_cast<double>(candidate.support));
  };
  const auto bringNearer = [&](Candidates& candidates, const Round& round) {
    const Candidates before = candidates;
    finer.bringNearer(candidates, round, progress);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      measure(candidates[i]);
      // A loss draws a half towards what it does not share; features tell.
      constexpr double most = 0.7;
      if (features && static_cast<double>(candidates[i].support) <
                          most * static_cast<double>(features->support(before[i].transform))) {
        candidates[i] = before[i];
        measure(candidates[i]);
      }
    }
    sortBy(rankOf, candidates);
    keepDistinct(candidates, from, 3 * coarse.voxel);
    keep(candidates, after_third);
  };
  Candidates candidates{starts[0]};
  if (features)
    for (const RigidTransform& pose : features->poses(by_features))
      candidates.push_back(allowed(pose));
  result.starts = candidates.size();
  bringNearer(candidates, {15, 2});
  bringNearer(candidates, {10, 1});
  if (areDecided(candidates))
    progress.expect(1);
  progress.add();
  if (!areDecided(candidates)) {
    result.starts += starts.size() - 1;
    const auto byScore = [](const Candidate& each) { return each.score; };
    const Level coarser(device_, coarse, motions_, false, lanes_, share_);
    coarser.bringNearer(starts, {5, 4}, progress);
    sortBy(byScore, starts);
    keep(starts, after_first);
    coarser.bringNearer(starts, {10, 2}, progress);
    sortBy(byScore, starts);
    keepDistinct(starts, from, 3 * coarse.voxel);
    keep(starts, after_second);
    bringNearer(starts, {15, 4});
    candidates.insert(candidates.begin(), starts.begin(), starts.end());
    bringNearer(candidates, {10, 1});
    progress.expect(1);
    progress.add();
  }
  candidates.erase(
      std::remove_if(candidates.begin(), candidates.end(), [](const Candidate& c) { return !(c.score > 0); }),
      candidates.end());
  std::vector<RigidTransform> poses(candidates.size());
  std::transform(candidates.begin(), candidates.end(), poses.begin(), [&placed](const Candidate& candidate) {
    return placed.betweenClouds(candidate.transform);
  });
  const std::vector<Quality> qualities = qualitiesOf(source, target, guess, poses);
  for (std::size_t i = 0; i < poses.size(); ++i)
    result.poses.push_back({poses[i], candidates[i].score, candidates[i].support, qualities[i]});
  return result;
}

} // namespace pcl_gpu_icp
