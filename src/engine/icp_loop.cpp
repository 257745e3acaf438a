#include <pcl_gpu_icp/icp_loop.h>

#include "anderson.h"
#include "search/bulk.h"

#include <cmath>
#include <limits>

namespace pcl_gpu_icp {

namespace {

RigidTransform iteratePlainly(IcpSteps& steps, const RigidTransform& guess)
{
  RigidTransform pose = guess;
  while (steps.match(pose)) {
    const RigidTransform increment = steps.estimateIncrement(pose);
    pose = compose(increment, pose);
    if (steps.finished(increment, pose))
      break;
  }
  return pose;
}

RigidTransform iterateAccelerated(IcpSteps& steps, const RigidTransform& guess, const Lever& lever)
{
  AndersonAcceleration acceleration(guess, lever);
  RigidTransform plain = guess;
  double error = std::numeric_limits<double>::infinity();
  for (RigidTransform pose = guess;;) {
    bool matched = steps.match(pose);
    if (!matched || steps.error() > error) {
      acceleration.forget();
      pose = plain;
      matched = steps.match(pose);
    }
    if (!matched)
      return plain;
    error = steps.error();
    const RigidTransform increment = steps.estimateIncrement(pose);
    plain = compose(increment, pose);
    if (steps.finished(increment, plain))
      return plain;
    pose = acceleration.accelerated(pose, plain);
  }
}

struct Measured {
  Lever lever;
  std::size_t points = 0; ///< that it is of
};

Measured measured(const Points& points)
{
  const search::Bulk bulk(points);
  Measured result;
  Lever& lever = result.lever;
  std::array<double, 3> sum{};
  for (std::size_t i = 0; i < points.count; ++i)
    if (bulk.holds(points[i])) {
      ++result.points;
      for (int axis = 0; axis < 3; ++axis)
        sum[axis] += points[i][axis] - bulk.median()[axis];
    }
  if (result.points == 0)
    return result;
  const auto n = static_cast<double>(result.points);
  for (int axis = 0; axis < 3; ++axis)
    lever.centre[axis] = bulk.median()[axis] + sum[axis] / n;
  double squares = 0;
  for (std::size_t i = 0; i < points.count; ++i)
    if (bulk.holds(points[i]))
      for (int axis = 0; axis < 3; ++axis)
        squares += (points[i][axis] - lever.centre[axis]) * (points[i][axis] - lever.centre[axis]);
  lever.length = std::sqrt(squares / n);
  return result;
}

} // namespace

Lever leverOf(const Points& points) { return measured(points).lever; }

double surfaceSpacing(double radius, std::size_t points)
{
  return points > 0 ? 2.5 * radius / std::sqrt(static_cast<double>(points)) : 0;
}

double surfaceSpacing(const Points& points)
{
  const Measured cloud = measured(points);
  return surfaceSpacing(cloud.lever.length, cloud.points);
}

RigidTransform iterate(IcpSteps& steps, const RigidTransform& guess, const std::optional<Lever>& acceleration)
{
  return acceleration ? iterateAccelerated(steps, guess, *acceleration) : iteratePlainly(steps, guess);
}

} // namespace pcl_gpu_icp
