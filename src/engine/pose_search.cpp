#include <pcl_gpu_icp/pose_search.h>

#include "feature_matches.h"
#include "geometry/vector.h"
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
#include <optional>
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
      matcher.setSteps(1);
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
void keepApart(Candidates& candidates, const std::array<double, 3>& place, double near)
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

/// The search for one pair's pose.
class PairSearch {
public:
  struct Settings {
    const Device& device;
    Motions motions;
    unsigned lanes;
    std::shared_ptr<DeviceShare> share;
    std::function<void(std::size_t, std::size_t)> progress;
  };

  PairSearch(const PlacedPair& placed,
             const ThinPair& coarse,
             const ThinPair& fine,
             const RigidTransform& guess,
             const Settings& settings)
  : placed_(placed)
  , coarse_(coarse)
  , settings_(settings)
  , start_(placed.aboutPivots(guess))
  , from_(centroidOf(coarse.source))
  , onto_(centroidOf(coarse.target))
  , starts_(evenlySpread())
  , progress_(settings.progress, groupsByFeatures() + groupsByStarts())
  , has_surfaces_(hasSurfaces(fine, settings.motions))
  , finer_(settings.device, fine, settings.motions, has_surfaces_, settings.lanes, settings.share)
  , score_(settings.device, fine, 4 * fine.voxel, settings.share)
  {
    if (has_surfaces_)
      features_.emplace(settings.device, placed.source_points, placed.target_points, settings.share);
  }

  /// The best first.
  Candidates run()
  {
    Candidates candidates = byFeatures();
    if (areDecided(candidates))
      progress_.expect(1);
    progress_.add();
    if (!areDecided(candidates)) {
      const Candidates others = byStarts();
      candidates.insert(candidates.begin(), others.begin(), others.end());
      settle(candidates);
      progress_.expect(1);
      progress_.add();
    }
    candidates.erase(
        std::remove_if(candidates.begin(), candidates.end(), [](const Candidate& c) { return !(c.score > 0); }),
        candidates.end());
    return candidates;
  }

  /// That were tried.
  std::size_t starts() const { return tried_; }

private:
  // As many candidates as go on.
  static constexpr std::size_t by_features = 16, after_first = 200, after_second = 40, after_third = 8;
  // The guess goes on wherever it ranks, and may be there twice.
  static std::size_t groupsToSettle() { return Level::groupsOf(2 * after_third + 2) + 1; }
  static std::size_t groupsByFeatures() { return Level::groupsOf(by_features + 1) + groupsToSettle(); }
  std::size_t groupsByStarts() const
  {
    return Level::groupsOf(starts_.size()) + Level::groupsOf(after_first + 1) + Level::groupsOf(after_second + 1) +
           groupsToSettle();
  }

  /// What the motions leave of a pose, the source's centroid held.
  Candidate allowed(const RigidTransform& pose) const
  {
    const RigidTransform motion =
        restricted(compose(pose, inverse(start_)), settings_.motions, start_(from_[0], from_[1], from_[2]));
    return Candidate{compose(motion, start_)};
  }

  /// Turns all over, each with the centroids and, where that is another pose, the clouds' origins on each other. The
  /// guess is the first.
  Candidates evenlySpread() const
  {
    Candidates starts{{start_, 0, true}};
    const auto& pivot = placed_.source_pivot;
    const std::array<double, 3> origin{-pivot[0], -pivot[1], -pivot[2]},
        place = start_(origin[0], origin[1], origin[2]);
    for (const auto& turn : turnsOf(settings_.motions)) {
      RigidTransform turned;
      turned.rotation = compose({turn, {}}, start_).rotation;
      const auto add = [&](const std::array<double, 3>& point, const std::array<double, 3>& image) {
        RigidTransform pose = turned;
        const auto moved = turned(point[0], point[1], point[2]);
        for (int axis = 0; axis < 3; ++axis)
          pose.translation[axis] = image[axis] - moved[axis];
        starts.push_back(allowed(pose));
      };
      add(from_, onto_);
      if (distance(turned(from_[0] - origin[0], from_[1] - origin[1], from_[2] - origin[2]),
                   {onto_[0] - place[0], onto_[1] - place[1], onto_[2] - place[2]}) > 2 * coarse_.voxel)
        add(origin, place);
    }
    return starts;
  }

  /// What matches of features agree on, and the guess.
  Candidates byFeatures()
  {
    Candidates candidates{starts_[0]};
    if (features_)
      for (const RigidTransform& pose : features_->poses(by_features))
        candidates.push_back(allowed(pose));
    tried_ = candidates.size();
    bringNearer(candidates, {15, 2});
    settle(candidates);
    return candidates;
  }

  /// What the best of all starts lead to.
  Candidates byStarts()
  {
    Candidates candidates = starts_;
    tried_ += candidates.size() - 1;
    const auto byScore = [](const Candidate& each) { return each.score; };
    const Level coarser(settings_.device, coarse_, settings_.motions, false, settings_.lanes, settings_.share);
    coarser.bringNearer(candidates, {5, 4}, progress_);
    sortBy(byScore, candidates);
    keep(candidates, after_first);
    coarser.bringNearer(candidates, {10, 2}, progress_);
    sortBy(byScore, candidates);
    keepDistinct(candidates);
    keep(candidates, after_second);
    bringNearer(candidates, {15, 4});
    return candidates;
  }

  /// On the finer clouds; the best and distinct ones are left, the best first.
  void bringNearer(Candidates& candidates, const Round& round)
  {
    const Candidates before = candidates;
    finer_.bringNearer(candidates, round, progress_);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      measure(candidates[i]);
      // A loss draws a half towards what it does not share; features tell.
      constexpr double most = 0.7;
      if (features_ && static_cast<double>(candidates[i].support) <
                           most * static_cast<double>(features_->support(before[i].transform))) {
        candidates[i] = before[i];
        measure(candidates[i]);
      }
    }
    order(candidates);
    keep(candidates, after_third);
  }

  /// Where they stay. What the clouds do not share draws at points and planes; matches of features it leaves alone.
  void settle(Candidates& candidates)
  {
    bringNearer(candidates, {10, 1});
    if (!features_)
      return;
    for (Candidate& candidate : candidates) {
      candidate.transform = allowed(features_->fitted(candidate.transform)).transform;
      measure(candidate);
    }
    order(candidates);
  }

  static double byBoth(const Candidate& candidate)
  {
    return candidate.score * static_cast<double>(support_by_chance + candidate.support);
  }

  /// The best first, of those that are near each other one.
  void order(Candidates& candidates) const
  {
    sortBy(byBoth, candidates);
    keepDistinct(candidates);
  }

  void measure(Candidate& candidate)
  {
    candidate.score = score_(candidate.transform);
    candidate.support = features_ ? features_->support(candidate.transform) : 0;
  }

  void keepDistinct(Candidates& candidates) const { keepApart(candidates, from_, 3 * coarse_.voxel); }

  const PlacedPair& placed_;
  const ThinPair& coarse_;
  Settings settings_;
  RigidTransform start_; ///< poses are between the clouds about their pivots
  std::array<double, 3> from_, onto_;
  Candidates starts_;
  Progress progress_;
  bool has_surfaces_;
  Level finer_;
  TwoWayScore score_;
  std::optional<FeatureMatches> features_; ///< none: there are no surfaces
  std::size_t tried_ = 0;
};

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
  constexpr std::size_t coarse_points = 500, fine_points = 4000, fewest_voxels = 4;
  const double coarse_size = search::voxelSizeFor(placed.source_points, coarse_points);
  const double fine_size = search::voxelSizeFor(placed.source_points, fine_points);
  if (!(coarse_size > 0 && fine_size > 0))
    return result;
  const ThinPair coarse(placed.source_points, placed.target_points, coarse_size);
  const ThinPair fine(placed.source_points, placed.target_points, fine_size);
  for (const auto* thinned : {&coarse.source, &coarse.target, &fine.source, &fine.target})
    if (thinned->size() < fewest_voxels)
      return result;

  PairSearch search(placed, coarse, fine, guess, {device_, motions_, lanes_, share_, progress_});
  const Candidates candidates = search.run();
  result.starts = search.starts();
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
