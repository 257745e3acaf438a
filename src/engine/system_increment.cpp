#include "system_increment.h"

#include "search/bulk.h"
#include "solution.h"
#include "values_at.h"

#include <pcl_gpu_icp/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace pcl_gpu_icp {

namespace {

template <typename real>
std::array<double, SYSTEM_SUMS> download(opencl::Queue& queue, const opencl::Buffer& total)
{
  std::array<double, SYSTEM_SUMS> sums{};
  queue.download(total, SYSTEM_SUMS * sizeof(real), [&](const void* memory) {
    const auto* values = static_cast<const real*>(memory);
    std::copy(values, values + SYSTEM_SUMS, sums.begin());
  });
  return sums;
}

/// `width` floats of each of the caller's points, in the order of the leaves.
template <std::size_t width>
std::vector<std::array<float, width>> inOrder(const std::vector<PlacedPoint>& target, const Points& values)
{
  std::vector<std::array<float, width>> in_order(target.size());
  for (std::size_t i = 0; i < target.size(); ++i) {
    const float* value = valuesAt(values, target[i].position);
    std::copy(value, value + width, in_order[i].begin());
  }
  return in_order;
}

/// Of the increment, in the frame that it is estimated in.
RigidTransform motionOf(const Estimate& estimate) { return {estimate.stages.R, estimate.stages.t}; }

/// Of a small rotation, in radians.
double angleOf(const RigidTransform& motion)
{
  const auto& R = motion.rotation;
  return std::hypot(R[7] - R[5], R[2] - R[6], R[3] - R[1]) / 2;
}

} // namespace

void SystemIncrement::measureRounding(const std::vector<PlacedPoint>& target, const std::array<double, 3>& pivot)
{
  const auto largest = search::Bulk(viewOf(target)).largest(viewOf(target), pivot);
  for (int axis = 0; axis < 3; ++axis)
    rounding_[axis] = largest[axis] * std::numeric_limits<float>::epsilon() / 2;
}

void SystemIncrement::setNormals(opencl::Queue& queue,
                                 const std::vector<PlacedPoint>& target,
                                 const std::array<double, 3>& pivot,
                                 const Points& normals)
{
  metric_ = Metric::Plane;
  measureRounding(target, pivot);
  stages::packNormals(queue, inOrder<3>(target, normals), own_);
}

void SystemIncrement::setTargetCovariances(opencl::Queue& queue,
                                           const std::vector<PlacedPoint>& target,
                                           const std::array<double, 3>& pivot,
                                           const Points& covariances)
{
  metric_ = Metric::Generalized;
  measureRounding(target, pivot);
  stages::packTargetCovariances(queue, inOrder<COVARIANCE_ROWS>(target, covariances), own_);
}

void SystemIncrement::setSource(const std::vector<PlacedPoint>& source)
{
  source_points_ = source.size();
  source_covariances_ = 0;
  lever_ = leverOf(viewOf(source));
}

void SystemIncrement::setSourceCovariances(opencl::Queue& queue,
                                           const std::vector<stages::Covariance>& in_order,
                                           const stages::SourcePoints& source)
{
  stages::packSourceCovariances(queue, in_order, source, own_);
  source_covariances_ = in_order.size();
}

double SystemIncrement::rowNoise(const System& system) const
{
  // A normal is no better than the points it comes of: their rounding along it, seen from a neighbour.
  const double spacing = surfaceSpacing(system.length, source_points_);
  // The places of sum n n^T's diagonal in the upper triangle of six.
  const double squares[3] = {system.sums[15], system.sums[18], system.sums[20]};
  const double weight = system.weight();
  double along_sq = 0;
  for (int axis = 0; axis < 3; ++axis)
    along_sq += weight > 0 ? squares[axis] / weight * rounding_[axis] * rounding_[axis] : 0;
  return std::hypot(std::sqrt(along_sq) / spacing, std::numeric_limits<float>::epsilon());
}

System SystemIncrement::systemAt(opencl::Queue& queue,
                                 Precision precision,
                                 const stages::SourcePoints& source,
                                 const RigidTransform& pose,
                                 const RigidTransform& turn,
                                 const opencl::Buffer& matches,
                                 const stages::TargetPoints& target)
{
  const bool is_double = precision == Precision::Double;
  const std::size_t real_bytes = is_double ? sizeof(double) : sizeof(float);
  System system;
  system.centre = pose(lever_.centre[0], lever_.centre[1], lever_.centre[2]);
  for (double& coordinate : system.centre)
    coordinate = rounded<float>(coordinate);
  system.length = lever_.length > 0 ? lever_.length : 1;

  queue.reserve(total_, SYSTEM_SUMS * real_bytes);
  stage_.enqueue(queue, metric_, source, pose, turn, matches, target, own_, system.centre, real_bytes, total_);
  system.sums = is_double ? download<double>(queue, total_) : download<float>(queue, total_);
  requireFinite(system.sums, precision, metric_);
  system.row_noise = rowNoise(system);
  system.sum_noise = 8 * (is_double ? std::numeric_limits<double>::epsilon() : std::numeric_limits<float>::epsilon());
  return system;
}

Estimate SystemIncrement::estimate(opencl::Queue& queue,
                                   Precision precision,
                                   const stages::SourcePoints& source,
                                   const RigidTransform& pose,
                                   const opencl::Buffer& matches,
                                   const stages::TargetPoints& target)
{
  // The cost is quadratic in the shift; what a step leaves over is of the order of its angle squared.
  constexpr double linear_angle = 1e-3;
  constexpr int steps_at_most = 20;

  if (metric_ == Metric::Generalized && source_covariances_ != source_points_)
    throw InvalidArgument("the source's points are " + std::to_string(source_points_) + ", its covariances " +
                          std::to_string(source_covariances_));
  System system = systemAt(queue, precision, source, pose, pose, matches, target);
  const double weight = system.weight();
  mean_squared_distance_ = weight > 0 ? system.cost() / weight : 0;
  Estimate step = solved(system);
  if (metric_ == Metric::Plane)
    return step;

  const std::array<double, 3> centre = system.centre;
  RigidTransform done; // from the pose to where `system` is of
  double share = 1;
  for (int steps = 1; steps < steps_at_most && angleOf(motionOf(step)) > linear_angle; ++steps) {
    const RigidTransform next = compose(motionOf(step), done);
    const System there = systemAt(queue, precision, source, inFloat(compose(next, pose)), pose, matches, target);
    const bool better = there.cost() <= system.cost();
    if (better) {
      system = there;
      done = next;
    }
    share = better ? 1 : share / 2;
    step = solved(system, share);
  }
  const RigidTransform motion = compose(motionOf(step), done);
  step.stages.R = motion.rotation;
  step.stages.t = motion.translation;
  step.stages.source_centroid = centre;
  step.stages.target_centroid = motion(centre[0], centre[1], centre[2]);
  return step;
}

} // namespace pcl_gpu_icp
