#include "anderson.h"

#include "geometry/rotation_vector.h"

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp {

namespace {

using Vector6 = std::array<double, 6>;

double dot(const Vector6& a, const Vector6& b)
{
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += a[i] * b[i];
  return sum;
}

/// a - factor b.
Vector6 minus(Vector6 a, const Vector6& b, double factor = 1)
{
  for (std::size_t i = 0; i < a.size(); ++i)
    a[i] -= factor * b[i];
  return a;
}

} // namespace

AndersonAcceleration::AndersonAcceleration(const RigidTransform& origin, const Lever& lever)
: origin_(origin)
, lever_(lever)
{
}

AndersonAcceleration::Coordinates AndersonAcceleration::coordinatesOf(const RigidTransform& pose) const
{
  const auto& c = lever_.centre;
  const auto rotation = rotationVector(compose(pose, inverse(origin_)).rotation);
  const auto from = origin_(c[0], c[1], c[2]), to = pose(c[0], c[1], c[2]);
  Coordinates coordinates{};
  for (int axis = 0; axis < 3; ++axis) {
    coordinates[axis] = lever_.length * rotation[axis];
    coordinates[3 + axis] = to[axis] - from[axis];
  }
  return coordinates;
}

RigidTransform AndersonAcceleration::poseAt(const Coordinates& coordinates) const
{
  RigidTransform turn;
  turn.rotation =
      rotationBy({coordinates[0] / lever_.length, coordinates[1] / lever_.length, coordinates[2] / lever_.length});
  RigidTransform pose = compose(turn, origin_);
  const auto& c = lever_.centre;
  const auto from = origin_(c[0], c[1], c[2]), turned = pose(c[0], c[1], c[2]);
  for (int axis = 0; axis < 3; ++axis)
    pose.translation[axis] += from[axis] + coordinates[3 + axis] - turned[axis];
  return pose;
}

RigidTransform AndersonAcceleration::accelerated(const RigidTransform& pose, const RigidTransform& next)
{
  if (!(lever_.length > 0))
    return next;
  const Coordinates plain = coordinatesOf(next);
  steps_.push_back({minus(plain, coordinatesOf(pose)), plain});
  if (steps_.size() > window + 1)
    steps_.erase(steps_.begin());

  // Least squares, residual = sum of weight_k (residual - residual_k): Gram-Schmidt over the differences, the newest
  // first; one that says nothing new is left out.
  constexpr double dependent = 1e-6;
  const Step& last = steps_.back();
  struct Direction {
    Vector6 unit;    ///< of the differences of residuals
    Vector6 of_next; ///< what goes with it in `next`
  };
  std::vector<Direction> directions;
  for (std::size_t age = 1; age < steps_.size(); ++age) {
    const Step& earlier = steps_[steps_.size() - 1 - age];
    Vector6 residual = minus(last.residual, earlier.residual), along = minus(last.next, earlier.next);
    const double length = std::sqrt(dot(residual, residual));
    for (const Direction& d : directions) {
      const double share = dot(d.unit, residual);
      residual = minus(residual, d.unit, share);
      along = minus(along, d.of_next, share);
    }
    const double rest = std::sqrt(dot(residual, residual));
    if (!(rest > dependent * length))
      continue;
    directions.push_back({minus({}, residual, -1 / rest), minus({}, along, -1 / rest)});
  }
  Coordinates best = last.next;
  for (const Direction& d : directions)
    best = minus(best, d.of_next, dot(d.unit, last.residual));
  const bool finite = std::all_of(best.begin(), best.end(), [](double x) { return std::isfinite(x); });
  return finite && !directions.empty() ? poseAt(best) : next;
}

} // namespace pcl_gpu_icp
