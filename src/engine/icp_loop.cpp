#include <pcl_gpu_icp/icp_loop.h>

#include "anderson.h"

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

} // namespace

Lever leverOf(const Points& points)
{
  Lever lever;
  if (points.count == 0)
    return lever;
  const auto n = static_cast<double>(points.count);
  for (std::size_t i = 0; i < points.count; ++i)
    for (int axis = 0; axis < 3; ++axis)
      lever.centre[axis] += points[i][axis] / n;
  double squares = 0;
  for (std::size_t i = 0; i < points.count; ++i)
    for (int axis = 0; axis < 3; ++axis)
      squares += (points[i][axis] - lever.centre[axis]) * (points[i][axis] - lever.centre[axis]);
  lever.length = std::sqrt(squares / n);
  return lever;
}

RigidTransform iterate(IcpSteps& steps, const RigidTransform& guess, const std::optional<Lever>& acceleration)
{
  return acceleration ? iterateAccelerated(steps, guess, *acceleration) : iteratePlainly(steps, guess);
}

} // namespace pcl_gpu_icp
