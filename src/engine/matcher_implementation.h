#pragma once

#include "match_target.h"
#include "motion.h"
#include "point_pairs.h"
#include "solution.h"
#include "stages/launch.h"
#include "stages/match.h"
#include "system_increment.h"
#include "values_at.h"

#include <pcl_gpu_icp/matcher.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_gpu_icp {

/// Of a moved point and one of a cloud.
inline double squaredDistance(const std::array<double, 3>& a, const float* b)
{
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis)
    sum += (a[axis] - b[axis]) * (a[axis] - b[axis]);
  return sum;
}

/// What a Matcher holds: two clouds on a device, and what makes increments of their matches.
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
    effort.limit_sq = std::max(std::nextafter(max_squared_distance, std::numeric_limits<float>::infinity()),
                               std::numeric_limits<float>::min());
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

  /// `width` floats of each of the source's points, in the order of its rows.
  /// \param follow whether those of the target are set
  /// \param whose what to call them
  template <std::size_t width>
  std::vector<std::array<float, width>> inSourceOrder(const Points& values, bool follow, const char* whose) const
  {
    if (!follow)
      throw InvalidArgument(std::string(whose) + " come after those of the target");
    for (const std::int32_t position : source_positions)
      requireOneEach(position, values.count, whose);
    std::vector<std::array<float, width>> in_order(source.points.size());
    for (std::size_t i = 0; i < in_order.size(); ++i) {
      const float* value = valuesAt(values, source_positions[source.points[i].position]);
      std::copy(value, value + width, in_order[i].begin());
    }
    return in_order;
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

} // namespace pcl_gpu_icp
