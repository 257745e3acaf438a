#include <pcl_gpu_icp/matcher.h>

#include "match_target.h"
#include "matcher_internals.h"
#include "motion.h"
#include "point_pairs.h"
#include "search/box_tree.h"
#include "solution.h"
#include "stages/launch.h"
#include "stages/match.h"
#include "system_increment.h"
#include "values_at.h"

#include <pcl_gpu_icp/error.h>
#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

namespace pcl_gpu_icp {

namespace {

float nextUp(float x) { return std::nextafter(x, std::numeric_limits<float>::infinity()); }

double squaredDistance(const std::array<double, 3>& a, const float* b)
{
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis)
    sum += (a[axis] - b[axis]) * (a[axis] - b[axis]);
  return sum;
}

/// \throws InvalidArgument when `count` values are not one for the point at that position of the caller's cloud
void requireOneEach(std::int32_t position, std::size_t count, const char* values)
{
  if (static_cast<std::size_t>(position) >= count)
    throw InvalidArgument(std::string("the ") + values + " are " + std::to_string(count) + ", and there is point " +
                          std::to_string(position));
}
void requireOneEach(const std::vector<PlacedPoint>& points, std::size_t count, const char* values)
{
  for (const PlacedPoint& point : points)
    requireOneEach(point.position, count, values);
}

} // namespace

struct Matcher::Implementation {
  Implementation(const Device& on, const opencl::Traits& traits, Precision wanted_precision)
  : device(on)
  , precision(stages::available(wanted_precision, traits))
  , queue(device, traits, stages::buildOptions(traits, precision))
  {
  }

  bool isDouble() const { return precision == Precision::Double; }
  std::size_t realBytes() const { return isDouble() ? sizeof(double) : sizeof(float); }

  DevicePose onDevice(const RigidTransform& pose) const { return {pose, source.pivot, target->cloud.pivot}; }

  /// Looking for more than the nearest pays while what is found lasts: several of the steps to come, which shrink. On
  /// the device it pays only once steps are short, on the host, where a search costs ten times as much, from the start.
  stages::SearchEffort effortFor(const RigidTransform& pose, float max_squared_distance)
  {
    stages::SearchEffort effort;
    // A subnormal limit is 0 to some devices.
    effort.limit_sq = std::max(nextUp(max_squared_distance), std::numeric_limits<float>::min());
    const double step = motion.stepTo(pose);
    const float spacing = target->spacing;
    if (target->index)
      effort.slack = static_cast<float>(std::min(4 * step + 0.2 * spacing, 1.0 * spacing));
    else if (step < 0.1 * spacing)
      effort.slack = static_cast<float>(5 * step);
    else
      return effort;
    effort.kept = KEPT_CANDIDATES;
    return effort;
  }

  /// Sets what increments are made by; where that fails it is the five stages again.
  template <typename Set>
  void measureBy(const Set& set)
  {
    system.emplace();
    try {
      set(*system);
      system->setSource(source.points);
    } catch (...) {
      system.reset();
      throw;
    }
  }

  /// Whether increments are those of normal equations, and not the five stages'.
  bool solvesSystem() const { return (system && system->metric() != Metric::Point) || !objective.isPlain(); }

  /// Puts the increment of normal equations over `pairs` in the place of the one there.
  void solveSystem(const RigidTransform& pose, const opencl::Buffer& pairs, Matches& matches)
  {
    if (!system)
      measureBy([&](SystemIncrement& points) { points.setPoints(target->cloud.points, target->cloud.pivot); });
    const std::size_t count = matches.increment.pairs;
    const Degeneracy of_points = matches.increment.degeneracy;
    matches.increment = system->estimate(queue, precision, source_rows, pose, pairs, target->on_device, objective);
    matches.increment.pairs = count;
    if (system->metric() == Metric::Point && (of_points == Degeneracy::Line || of_points == Degeneracy::Point)) {
      matches.increment.degeneracy = of_points;
      matches.increment.free_motions = 0;
    }
    matches.mean_squared_residual = system->meanSquaredDistance();
    matches.loss_scale = system->lossScale();
  }

  /// Pairs as points, with the source at a pose.
  PointPairs pointsOf(const opencl::Buffer& pairs, const RigidTransform& pose)
  {
    const Sample sample(source.points.size());
    PointPairs points(pose(0, 0, 0), sample.each());
    queue.download(pairs, source.points.size() * sizeof(cl_int), [&](const void* memory) {
      const auto* matches = static_cast<const cl_int*>(memory);
      sample.forEach([&](std::size_t i) {
        if (matches[i] < 0)
          return;
        const float* p = source.points[i].xyz;
        const auto moved = pose(p[0], p[1], p[2]);
        points.add(moved, squaredDistance(moved, target->cloud.points[matches[i]].xyz));
      });
    });
    return points;
  }

  std::optional<Uncertainty> uncertainty(const RigidTransform& pose)
  {
    if (!paired)
      return std::nullopt;
    const PointPairs points = pointsOf(*paired, pose);
    if (!solvesSystem())
      return points.uncertainty(std::sqrt(static_cast<double>(source.rounding) * target->cloud.rounding));
    return system->uncertainty(
        queue, precision, source_rows, pose, *paired, target->on_device, objective, points, target->spacing);
  }

  /// The increment in the callers' frames.
  void complete(Estimate& increment, const DevicePose& pose) const
  {
    pose.completeIncrement(increment);
    if (increment.pairs > 0)
      increment.transform = restricted(increment.transform, objective.motions, increment.sourceCentroid());
  }

  /// What the sums on the device amount to.
  Matches solution()
  {
    queue.reserve(summary, isDouble() ? sizeof(MatchSummary<double>) : sizeof(MatchSummary<float>));
    stage.solve(queue, source_rows, source.rounding * target->cloud.rounding, summary);
    return isDouble() ? read<double>() : read<float>();
  }

  template <typename real>
  Matches read()
  {
    Matches matches;
    queue.download(summary, sizeof(MatchSummary<real>), [&](const void* memory) {
      const auto& record = *static_cast<const MatchSummary<real>*>(memory);
      matches.searched = record.searched;
      matches.increment.pairs = record.matched;
      if (record.matched == 0) {
        matches.increment.degeneracy = Degeneracy::Empty;
        return;
      }
      matches.mean_squared_distance = static_cast<double>(record.squared_distances) / record.matched;
      copySolution(record.solution, matches.increment);
    });
    requireFinite(matches.increment, precision);
    return matches;
  }

  /// Puts a target on the device by a queue of its own, which waits: matchers use it on other queues.
  template <typename Pack>
  void fill(MatchTarget& made, const Pack& pack)
  {
    opencl::Queue own(device, queue.traits(), "");
    pack(own);
    for (const auto& [what, entry] : own.takeProfile().entries) {
      target_times[what].milliseconds += entry.milliseconds;
      target_times[what].count += entry.count;
    }
    made.device_bytes = own.allocated();
  }

  Device device;
  Precision precision;
  opencl::Queue queue;
  unsigned threads = 0;

  std::shared_ptr<const MatchTarget> target = std::make_shared<MatchTarget>();
  StageTimes target_times; ///< of those made, until they are taken

  PlacedCloud source; ///< a point's position is its place in source_positions
  stages::SourcePoints source_rows;
  std::vector<std::int32_t> source_positions;
  Motion motion;

  stages::Match stage;
  opencl::Buffer summary{"match summary"}, kept_matches{"kept matches"};
  const opencl::Buffer* paired = nullptr; ///< what the last increment was of; null: there is none
  std::optional<SystemIncrement> system;  ///< makes the increments where they are not the five stages'
  Objective objective;
};

Matcher::Matcher(const Device& device,
                 CorrespondenceSearch search,
                 Precision precision,
                 Metric metric,
                 const Loss& loss,
                 Motions motions)
: Matcher(makeMatcher(device, opencl::Traits::of(device.info()), precision))
{
  const float points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const Points cloud{points, 3, 3 * sizeof(float)};
  if (search == CorrespondenceSearch::PclKdTree) {
    const auto index = std::make_shared<search::NearestIndex>();
    index->build(cloud);
    setTarget(makeTarget(index));
  }
  else
    setTarget(makeTarget(cloud));
  setSource(cloud);
  if (metric == Metric::Plane)
    setTargetNormals(cloud);
  if (metric == Metric::Generalized) {
    constexpr std::array<float, COVARIANCE_ROWS> identity{1, 0, 0, 1, 0, 1};
    const Points covariances{identity.data(), 3, 0};
    setTargetCovariances(covariances);
    setSourceCovariances(covariances);
  }
  setLoss(loss);
  setMotions(motions);
  match({}, 1);
  meanSquaredDistance({});
  takeTimes();
}
Matcher::Matcher(std::unique_ptr<Implementation> implementation)
: implementation_(std::move(implementation))
{
}
Matcher::~Matcher() = default;
Matcher::Matcher(Matcher&&) noexcept = default;
Matcher& Matcher::operator=(Matcher&&) noexcept = default;

Matcher makeMatcher(const Device& device, const opencl::Traits& traits, Precision precision)
{
  return Matcher(std::make_unique<Matcher::Implementation>(device, traits, precision));
}

const DeviceInfo& Matcher::device() const { return implementation_->queue.info(); }
Precision Matcher::precision() const { return implementation_->precision; }
void Matcher::setShare(std::shared_ptr<DeviceShare> share) { implementation_->queue.setShare(std::move(share)); }
void Matcher::setNumberOfThreads(unsigned threads) { implementation_->threads = threads; }
std::size_t Matcher::targetSize() const { return implementation_->target->cloud.points.size(); }
const std::array<double, 3>& Matcher::sourcePivot() const { return implementation_->source.pivot; }

std::shared_ptr<const MatchTarget> Matcher::makeTarget(const Points& target) const
{
  const unsigned threads = effectiveThreads(implementation_->threads);
  auto made = std::make_shared<MatchTarget>();
  auto& points = made->cloud.points;
  made->cloud.place(target, threads);
  search::dropCoincident(points);
  search::sortIntoLeaves(points, threads);
  made->spacing = search::spacingOf(points);
  implementation_->fill(
      *made, [&](opencl::Queue& queue) { stages::packTree(queue, search::BoxTree(points, threads), made->on_device); });
  return made;
}

std::shared_ptr<const MatchTarget> Matcher::makeTarget(std::shared_ptr<const search::NearestIndex> index) const
{
  auto made = std::make_shared<MatchTarget>();
  made->cloud.place(*index);
  made->spacing = index->spacing();
  implementation_->fill(*made,
                        [&](opencl::Queue& queue) { stages::packLeaves(queue, index->points(), made->on_device); });
  made->index = std::move(index);
  return made;
}

void Matcher::setTarget(std::shared_ptr<const MatchTarget> target)
{
  Implementation& self = *implementation_;
  self.system.reset();
  self.paired = nullptr;
  self.target = std::move(target);
  self.stage.restart(self.queue, self.source_rows);
}

void Matcher::setTargetNormals(const Points& normals)
{
  Implementation& self = *implementation_;
  const PlacedCloud& target = self.target->cloud;
  requireOneEach(target.points, normals.count, "normals");
  self.measureBy([&](SystemIncrement& system) { system.setNormals(self.queue, target.points, target.pivot, normals); });
}

void Matcher::setTargetCovariances(const Points& covariances)
{
  Implementation& self = *implementation_;
  const PlacedCloud& target = self.target->cloud;
  requireOneEach(target.points, covariances.count, "covariances of the target");
  self.measureBy([&](SystemIncrement& system) {
    system.setTargetCovariances(self.queue, target.points, target.pivot, covariances);
  });
}

void Matcher::setSourceCovariances(const Points& covariances)
{
  Implementation& self = *implementation_;
  if (!self.system)
    throw InvalidArgument("covariances of the source come after those of the target");
  for (const std::int32_t position : self.source_positions)
    requireOneEach(position, covariances.count, "covariances of the source");
  std::vector<stages::Covariance> in_order(self.source.points.size());
  for (std::size_t i = 0; i < in_order.size(); ++i) {
    const std::int32_t position = self.source_positions[self.source.points[i].position];
    const float* covariance = valuesAt(covariances, position);
    std::copy(covariance, covariance + COVARIANCE_ROWS, in_order[i].begin());
  }
  self.system->setSourceCovariances(self.queue, in_order, self.source_rows);
}

void Matcher::setLoss(const Loss& loss)
{
  requireValid(loss);
  implementation_->objective.loss = loss;
}

void Matcher::setMotions(Motions motions) { implementation_->objective.motions = motions; }

void Matcher::setSource(const Points& source)
{
  Implementation& self = *implementation_;
  const unsigned threads = effectiveThreads(self.threads);
  self.source.place(source, threads);
  auto& points = self.source.points;
  self.source_positions.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    self.source_positions[i] = std::exchange(points[i].position, static_cast<std::int32_t>(i));
  search::sortIntoLeaves(points, threads);
  stages::packSource(self.queue, points, self.source_rows);
  self.motion.restart(points);
  if (self.system)
    self.system->setSource(points);
  self.paired = nullptr;
  self.stage.restart(self.queue, self.source_rows);
}

Matches Matcher::match(const RigidTransform& pose, float max_squared_distance, bool with_increment)
{
  if (!(max_squared_distance >= 0))
    throw InvalidArgument("a squared distance within which to match is at least 0, not " +
                          std::to_string(max_squared_distance));
  Implementation& self = *implementation_;
  const DevicePose device_pose = self.onDevice(pose);
  const RigidTransform& pivoted = device_pose.pivoted();
  Matches matches;
  if (self.source_rows.count > 0) {
    const stages::SearchEffort effort = self.effortFor(pivoted, max_squared_distance);
    if (!self.target->index) {
      self.stage.searchOnDevice(
          self.queue, self.source_rows, self.target->on_device, pivoted, effort, self.realBytes());
      matches = self.solution();
    }
    else {
      const auto search = [&](const stages::Query* queries, std::size_t count, cl_int* positions, float* reaches) {
        self.target->searchIndex(effort, effectiveThreads(self.threads), queries, count, positions, reaches);
      };
      const std::size_t searched =
          self.stage.searchOnHost(self.queue, self.source_rows, self.target->on_device, pivoted, effort, search);
      self.stage.sum(self.queue, self.source_rows, self.target->on_device, pivoted, self.realBytes());
      matches = self.solution();
      matches.searched = searched;
    }
  }
  else
    matches.increment.degeneracy = Degeneracy::Empty;
  matches.mean_squared_residual = matches.mean_squared_distance;
  self.paired = with_increment && matches.increment.pairs > 0 ? &self.stage.matches() : nullptr;
  if (self.paired && self.solvesSystem())
    self.solveSystem(pivoted, self.stage.matches(), matches);
  self.complete(matches.increment, device_pose);
  return matches;
}

double Matcher::meanSquaredDistance(const RigidTransform& pose)
{
  Implementation& self = *implementation_;
  if (self.source_rows.count == 0)
    return 0;
  self.stage.sum(self.queue, self.source_rows, self.target->on_device, self.onDevice(pose).pivoted(), self.realBytes());
  return self.solution().mean_squared_distance;
}

std::vector<Correspondence> Matcher::correspondences(const RigidTransform& pose) const
{
  Implementation& self = *implementation_;
  const auto& source = self.source.points;
  const auto& target = self.target->cloud.points;
  const RigidTransform pivoted = recentred(pose, self.source.pivot, self.target->cloud.pivot);
  std::vector<Correspondence> by_place(source.size());
  self.queue.download(self.stage.matches(), source.size() * sizeof(cl_int), [&](const void* memory) {
    const auto* matches = static_cast<const cl_int*>(memory);
    for (std::size_t i = 0; i < source.size(); ++i) {
      const std::int32_t place = source[i].position;
      Correspondence& c = by_place[place];
      c = {self.source_positions[place], -1, 0};
      if (matches[i] < 0)
        continue;
      c.target = target[matches[i]].position;
      const float* p = source[i].xyz;
      c.squared_distance = static_cast<float>(squaredDistance(pivoted(p[0], p[1], p[2]), target[matches[i]].xyz));
    }
  });
  by_place.erase(std::remove_if(by_place.begin(), by_place.end(), [](const Correspondence& c) { return c.target < 0; }),
                 by_place.end());
  return by_place;
}

Matches Matcher::estimate(const std::vector<Correspondence>& kept, const RigidTransform& pose)
{
  Implementation& self = *implementation_;
  if (!self.solvesSystem())
    throw InvalidArgument("an increment from some of the matches needs normals, covariances, a loss or motions");
  const DevicePose device_pose = self.onDevice(pose);
  Matches result;
  Estimate& estimate = result.increment;
  estimate.degeneracy = Degeneracy::Empty;
  if (!kept.empty()) {
    const auto last = std::max_element(self.source_positions.begin(), self.source_positions.end());
    std::vector<char> is_kept(last == self.source_positions.end() ? 0 : *last + 1);
    for (const Correspondence& c : kept) {
      if (c.source < 0 || static_cast<std::size_t>(c.source) >= is_kept.size())
        throw InvalidArgument("a correspondence names source point " + std::to_string(c.source) + ", which is none");
      is_kept[c.source] = 1;
    }
    std::vector<cl_int> matches(self.source_rows.stride, -1);
    self.queue.download(self.stage.matches(), self.source.points.size() * sizeof(cl_int), [&](const void* memory) {
      for (std::size_t i = 0; i < self.source.points.size(); ++i)
        if (is_kept[self.source_positions[self.source.points[i].position]] != 0)
          matches[i] = static_cast<const cl_int*>(memory)[i];
    });
    self.queue.upload(self.kept_matches, matches.size() * sizeof(cl_int), [&](void* memory) {
      std::copy(matches.begin(), matches.end(), static_cast<cl_int*>(memory));
    });
    estimate.pairs = kept.size();
    self.paired = &self.kept_matches;
    self.solveSystem(device_pose.pivoted(), self.kept_matches, result);
  }
  self.complete(estimate, device_pose);
  return result;
}

std::optional<Uncertainty> Matcher::uncertainty(const RigidTransform& pose)
{
  Implementation& self = *implementation_;
  if (self.source_rows.count == 0)
    return std::nullopt;
  auto uncertainty = self.uncertainty(self.onDevice(pose).pivoted());
  if (uncertainty)
    for (int axis = 0; axis < 3; ++axis)
      uncertainty->centre[axis] += self.target->cloud.pivot[axis];
  return uncertainty;
}

std::size_t Matcher::deviceBytes() const
{
  return implementation_->queue.allocated() + implementation_->target->device_bytes;
}

StageTimes Matcher::takeTimes()
{
  StageTimes times = std::exchange(implementation_->target_times, {});
  for (const auto& [what, entry] : implementation_->queue.takeProfile().entries) {
    times[what].milliseconds += entry.milliseconds;
    times[what].count += entry.count;
  }
  return times;
}

double meanSquaredDistance(const std::vector<Correspondence>& correspondences,
                           const Points& source,
                           const Points& target,
                           const RigidTransform& pose)
{
  double sum = 0;
  for (const Correspondence& c : correspondences) {
    const float* p = valuesAt(source, c.source);
    sum += squaredDistance(pose(p[0], p[1], p[2]), valuesAt(target, c.target));
  }
  return correspondences.empty() ? 0 : sum / static_cast<double>(correspondences.size());
}

} // namespace pcl_gpu_icp
