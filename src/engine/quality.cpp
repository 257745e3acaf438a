#include <pcl_gpu_icp/quality.h>

#include "box.h"
#include "qualities.h"
#include "sampled_cloud.h"
#include "search/bulk.h"
#include "search/surroundings.h"
#include "symmetric_eigen.h"

#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace pcl_gpu_icp {

namespace {

using search::foundAround;
using search::Nearby;
using search::Surroundings;

template <typename Found>
std::size_t reached(const std::vector<Found>& places)
{
  return static_cast<std::size_t>(
      std::count_if(places.begin(), places.end(), [](const Nearby& around) { return around.count > 0; }));
}

/// About the place that it was found around.
struct Surface {
  Place point, normal;
};

/// About their mean.
SquareMatrix<3> scatterOf(const Surroundings& around)
{
  const auto n = static_cast<double>(around.count);
  SquareMatrix<3> scatter{};
  std::size_t entry = 0;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column <= row; ++column)
      scatter[row][column] = scatter[column][row] =
          around.squares[entry++] / n - around.sum[row] * around.sum[column] / (n * n);
  return scatter;
}

/// Of a flat cloud, the curve within its plane.
std::optional<Surface> surfaceOf(const Surroundings& around, double radius, bool flat)
{
  constexpr std::size_t fewest_points = 6;
  constexpr double plainly = 4; // the ratio of variances
  if (around.count < fewest_points)
    return std::nullopt;
  SquareMatrix<3> scatter = scatterOf(around);
  const SquareMatrix<3> vectors = diagonalise(scatter);
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int a, int b) { return scatter[a][a] < scatter[b][b]; });
  const int normal = order[flat ? 1 : 0], next = order[flat ? 2 : 1];
  if (!(scatter[next][next] > plainly * scatter[normal][normal]))
    return std::nullopt;
  Surface surface;
  for (int axis = 0; axis < 3; ++axis) {
    surface.point[axis] = radius * around.sum[axis] / static_cast<double>(around.count);
    surface.normal[axis] = vectors[axis][normal];
  }
  return surface;
}

/// 3, of a flat cloud 2, of a line 1: directions in which it extends by more than a tenth of its spacing.
int dimensionsOf(const SampledCloud& cloud)
{
  constexpr double noticeable = 0.1;
  const search::Bulk bulk(viewOf(cloud.points));
  Surroundings all;
  for (const PlacedPoint& point : cloud.points)
    if (bulk.holds(point.xyz))
      all.add(std::array<double, 3>{point.xyz[0], point.xyz[1], point.xyz[2]}, 0);
  if (all.count == 0)
    return 0;
  SquareMatrix<3> scatter = scatterOf(all);
  diagonalise(scatter);
  int dimensions = 0;
  for (int i = 0; i < 3; ++i)
    dimensions += std::sqrt(std::max(scatter[i][i], 0.0)) > noticeable * cloud.spacing ? 1 : 0;
  return dimensions;
}

/// A point near the target, and the surface there.
struct PointOnSurface {
  Place place, normal;
  double distance; ///< of the surface from the place along the normal, in spacings
};

/// What a few robust steps (Geman-McClure, of one spacing) of points onto planes come to, and the smallest eigenvalue
/// of their information but for some that are of no account.
void measureStep(const std::vector<PointOnSurface>& points, int of_no_account, SurfaceFit& surfaces)
{
  constexpr int iterations = 5;
  constexpr double determined = 1e-3;
  const auto n = static_cast<double>(points.size());
  Place centre{};
  for (const PointOnSurface& point : points)
    for (int axis = 0; axis < 3; ++axis)
      centre[axis] += point.place[axis] / n;
  double square = 0;
  for (const PointOnSurface& point : points)
    for (int axis = 0; axis < 3; ++axis)
      square += (point.place[axis] - centre[axis]) * (point.place[axis] - centre[axis]) / n;
  const double radius = square > 0 ? std::sqrt(square) : 1;
  std::array<double, 6> step{}; // turns, by what they move a point at the radius, and shifts, in spacings
  for (int iteration = 0; iteration < iterations; ++iteration) {
    SquareMatrix<6> information{};
    std::array<double, 6> gradient{};
    double weights = 0;
    for (const PointOnSurface& point : points) {
      const Place& normal = point.normal;
      Place p;
      for (int axis = 0; axis < 3; ++axis)
        p[axis] = (point.place[axis] - centre[axis]) / radius;
      const std::array<double, 6> jacobian{p[1] * normal[2] - p[2] * normal[1],
                                           p[2] * normal[0] - p[0] * normal[2],
                                           p[0] * normal[1] - p[1] * normal[0],
                                           normal[0],
                                           normal[1],
                                           normal[2]};
      double residual = -point.distance;
      for (int i = 0; i < 6; ++i)
        residual += jacobian[i] * step[i];
      const double root = 1 / (1 + residual * residual), weight = root * root;
      weights += weight;
      for (int i = 0; i < 6; ++i) {
        gradient[i] += weight * jacobian[i] * residual;
        for (int j = 0; j < 6; ++j)
          information[i][j] += weight * jacobian[i] * jacobian[j];
      }
    }
    const SquareMatrix<6> motions = diagonalise(information);
    std::array<double, 6> eigenvalues;
    for (int k = 0; k < 6; ++k) {
      eigenvalues[k] = information[k][k] / weights;
      if (eigenvalues[k] < determined)
        continue;
      double along = 0;
      for (int i = 0; i < 6; ++i)
        along += motions[i][k] * gradient[i];
      for (int i = 0; i < 6; ++i)
        step[i] -= along / information[k][k] * motions[i][k];
    }
    std::sort(eigenvalues.begin(), eigenvalues.end());
    surfaces.hold = std::max(eigenvalues[of_no_account], 0.0);
  }
  square = 0;
  for (const double x : step)
    square += x * x;
  surfaces.pull = std::sqrt(square);
}

/// Measures one pose after another.
class PosedPair {
public:
  PosedPair(const SampledCloud& source, const SampledCloud& target, unsigned threads)
  : source_(source)
  , target_(target)
  , threads_(threads)
  , box_(source.points)
  {
  }

  /// \param pose about the pivots
  /// \param onto_target what the samples of the source, there, find of the target
  template <typename Found>
  OverlapShares overlap(const RigidTransform& pose, const std::vector<Found>& onto_target) const
  {
    const double radius = near_spacings * std::max(source_.spacing, target_.spacing);
    const RigidTransform back = inverse(pose);
    std::vector<PlacedPoint> in_view;
    for (const PlacedPoint& point : target_.points) {
      if (box_.holds(back(point.xyz[0], point.xyz[1], point.xyz[2]), radius))
        in_view.push_back(point);
    }
    const auto seen = placesOf(thinned(viewOf(in_view), target_.samples.size()), back);
    return {share(reached(onto_target), onto_target.size()),
            share(reached(foundAround<Nearby>(seen, source_.points, radius, threads_)), seen.size())};
  }

  /// Within three spacings of the samples of the source.
  template <typename Found>
  std::vector<Found> ontoTarget(const std::vector<Place>& places) const
  {
    return foundAround<Found>(places, target_.points, near_spacings * target_.spacing, threads_);
  }

  void measure(const RigidTransform& pose, Quality& quality) const
  {
    const auto places = placesOf(source_.samples, pose);
    const auto around = ontoTarget<Surroundings>(places);
    const double source_radius = near_spacings * source_.spacing;
    const auto of_source =
        foundAround<Surroundings>(placesOf(source_.samples), source_.points, source_radius, threads_);
    quality.after = overlap(pose, around);
    std::vector<double> distances, plane_distances;
    std::vector<PointOnSurface> held;
    const int dimensions = dimensionsOf(source_);
    const bool flat = dimensions < 3;
    std::size_t close = 0, alike = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      distances.push_back(std::sqrt(around[i].nearest_sq) / target_.spacing);
      if (around[i].count == 0)
        continue;
      close += distances.back() <= 1 ? 1 : 0;
      const auto on_target = surfaceOf(around[i], near_spacings * target_.spacing, flat);
      const auto on_source = on_target ? surfaceOf(of_source[i], source_radius, flat) : std::nullopt;
      if (!on_source)
        continue;
      double cosine = 0, distance = 0;
      for (int row = 0; row < 3; ++row) {
        distance += on_target->normal[row] * on_target->point[row] / target_.spacing;
        for (int column = 0; column < 3; ++column)
          cosine += on_target->normal[row] * pose.rotation[3 * row + column] * on_source->normal[column];
      }
      constexpr double alike_cosine = 0.9, comparable_cosine = 0.7;
      alike += std::abs(cosine) > alike_cosine ? 1 : 0;
      plane_distances.push_back(std::abs(distance));
      if (std::abs(cosine) > comparable_cosine)
        held.push_back({places[i], on_target->normal, distance});
    }
    const std::size_t within = reached(around), measured = plane_distances.size();
    quality.median_distance = medianOf(std::move(distances));
    quality.concentration = share(close, within);
    constexpr double enough = 0.2;
    constexpr std::size_t fewest = 6; // a motion has so many unknowns
    const bool has_surfaces = dimensions > 1 && share(measured, within) >= enough && measured >= fewest;
    if (!has_surfaces && !flat)
      return;
    SurfaceFit& surfaces = quality.surfaces.emplace();
    surfaces.share = share(measured, within);
    if (!has_surfaces)
      return; // nothing that would hold what is flat
    surfaces.alike = share(alike, measured);
    surfaces.distance = medianOf(std::move(plane_distances));
    if (held.size() >= fewest)
      measureStep(held, flat ? 3 : 0, surfaces);
  }

private:
  const SampledCloud& source_;
  const SampledCloud& target_;
  unsigned threads_;
  Box box_; ///< around the source
};

} // namespace

double fitOf(const Quality& quality)
{
  const double overlap = std::sqrt(quality.after.source * quality.after.target);
  if (!quality.surfaces)
    return 0.5 * quality.concentration * overlap;
  return quality.concentration * quality.surfaces->alike * std::max(0.0, 1 - quality.surfaces->distance) * overlap;
}

std::vector<Quality> qualitiesOf(const Points& source,
                                 const Points& target,
                                 const RigidTransform& guess,
                                 const std::vector<RigidTransform>& poses,
                                 unsigned threads)
{
  threads = effectiveThreads(threads);
  const SampledCloud from(source, search::Bulk(source).median(), threads);
  const SampledCloud onto(target, search::Bulk(target).median(), threads);
  std::vector<Quality> qualities(poses.size());
  constexpr std::size_t fewest_points = 6; // as a surface has
  if (!(from.spacing > 0 && onto.spacing > 0) || std::min(from.points.size(), onto.points.size()) < fewest_points)
    return qualities;
  const PosedPair pair(from, onto, threads);
  const RigidTransform start = recentred(guess, from.pivot, onto.pivot);
  const OverlapShares before = pair.overlap(start, pair.ontoTarget<Nearby>(placesOf(from.samples, start)));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    qualities[i].spacing = onto.spacing;
    qualities[i].before = before;
    pair.measure(recentred(poses[i], from.pivot, onto.pivot), qualities[i]);
  }
  return qualities;
}

Quality qualityOf(const Points& source,
                  const Points& target,
                  const RigidTransform& guess,
                  const RigidTransform& pose,
                  unsigned threads)
{
  return qualitiesOf(source, target, guess, {pose}, threads).front();
}

} // namespace pcl_gpu_icp
