#include "cli/cloud_pair.h"

#include "cli/guess.h"

#include "report/ending.h"
#include "report/format.h"

#include <pcl_gpu_icp/search/nearest_index.h>
#include <pcl_gpu_icp/search/points_of.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace pcl_gpu_icp::cli {
namespace {

/// The least distance of a source point from the target.
double nearestDistance(const CloudPair& pair, const RigidTransform& transform)
{
  search::NearestIndex target;
  target.build(search::pointsOf(*pair.target->points));
  float least_sq = std::numeric_limits<float>::infinity();
  for (const pcl::PointXYZ& point : *pair.source->points) {
    const auto moved = transform(point.x, point.y, point.z);
    const float query[3] = {static_cast<float>(moved[0]), static_cast<float>(moved[1]), static_cast<float>(moved[2])};
    least_sq = std::min(least_sq, target.nearest(query).squared_distance);
  }
  return std::sqrt(least_sq);
}

/// Says where a guess's rotation is not taken as it was written.
std::optional<std::string> fewDigits(const RigidTransform& guess, const std::string& argument)
{
  constexpr double plainly_off = 1e-5; // of an entry; what seven digits leave is no news
  const RigidTransform taken = nearestRigid(guess, {0, 0, 0});
  double off = 0;
  for (std::size_t i = 0; i < guess.rotation.size(); ++i)
    off = std::max(off, std::abs(taken.rotation[i] - guess.rotation[i]));
  if (off <= plainly_off)
    return std::nullopt;
  return "--guess" + (namesFile(argument) ? " " + argument : "") +
         report::format(": written with few digits; the nearest rotation is taken, whose entries differ by up to %.1g",
                        off);
}

} // namespace

CloudPair::CloudPair(std::shared_ptr<const PreparedCloud> from,
                     std::shared_ptr<const PreparedCloud> to,
                     const RigidTransform& file_guess)
: source(std::move(from))
, target(std::move(to))
, guess(recentred(nearestRigid(file_guess, source->centroid), source->origin, target->origin))
{
}

RigidTransform CloudPair::inFileCoordinates(const RigidTransform& transform) const
{
  std::array<double, 3> from;
  std::array<double, 3> to;
  for (int i = 0; i < 3; ++i) {
    from[i] = -source->origin[i];
    to[i] = -target->origin[i];
  }
  return recentred(transform, from, to);
}

void describe(report::AlignmentReport& report,
              const AlignmentOptions& options,
              const CloudPair& pair,
              const RigidTransform& transform)
{
  report.only_good = options.strict;
  report.once = options.once;
  report.takes_undetermined = options.undetermined != Undetermined::Fail;
  report.iteration_limit = options.iterations;
  report.max_distance = options.max_distance;
  report.centroid = pair.source->centroid;
  report.guess = pair.inFileCoordinates(pair.guess);
  report.transform = pair.inFileCoordinates(transform);
  report.warnings = pair.warnings;
  report.resolution = pair.source->extent * std::numeric_limits<float>::epsilon();
  report.source_points = pair.source->counts;
  report.target_points = pair.target->counts;
  report.target_points.coincident = report.result.target_dropped;
  report.target_points.used = report.result.target_points;
  if (report.result.uncertainty)
    for (int axis = 0; axis < 3; ++axis)
      report.result.uncertainty->centre[axis] += pair.target->origin[axis];
  if (endingOf(report) == report::Ending::TooFewPairs)
    report.nearest_distance = nearestDistance(pair, transform);
}

CloudPair readPair(const AlignmentOptions& options, const ReadPrepared& prepared)
{
  const bool given = options.guess && !asksForSearch(*options.guess);
  const RigidTransform guess = given ? readGuess(*options.guess) : RigidTransform();
  auto source = prepared(options.source);
  CloudPair pair(std::move(source), prepared(options.target), guess);
  if (given)
    if (const auto warning = fewDigits(guess, *options.guess))
      pair.warnings.push_back(*warning);
  append(pair.warnings, pair.source->warnings);
  if (options.target != options.source)
    append(pair.warnings, pair.target->warnings);
  if (const auto warning = unlikeUnits(pair.source->scale, options.source, pair.target->scale, options.target))
    pair.warnings.push_back(*warning);
  return pair;
}

} // namespace pcl_gpu_icp::cli
