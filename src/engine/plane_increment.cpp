#include "plane_increment.h"

#include "search/bulk.h"
#include "solution.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_gpu_icp {

namespace {

template <typename real>
std::array<double, PLANE_SUMS> download(opencl::Queue& queue, const opencl::Buffer& total)
{
  std::array<double, PLANE_SUMS> sums{};
  queue.download(total, PLANE_SUMS * sizeof(real), [&](const void* memory) {
    const auto* values = static_cast<const real*>(memory);
    std::copy(values, values + PLANE_SUMS, sums.begin());
  });
  return sums;
}

} // namespace

void PlaneIncrement::setNormals(opencl::Queue& queue,
                                const std::vector<PlacedPoint>& target,
                                const std::array<double, 3>& pivot,
                                const Points& normals)
{
  const auto normalAt = [&](std::int32_t position) {
    return reinterpret_cast<const float*>(static_cast<const char*>(normals.data) + position * normals.stride);
  };
  std::vector<std::array<float, 3>> in_order;
  in_order.reserve(target.size());
  for (const PlacedPoint& point : target) {
    const float* normal = normalAt(point.position);
    in_order.push_back({normal[0], normal[1], normal[2]});
  }
  const auto largest = search::Bulk(viewOf(target)).largest(viewOf(target), pivot);
  for (int axis = 0; axis < 3; ++axis)
    rounding_[axis] = largest[axis] * std::numeric_limits<float>::epsilon() / 2;
  stages::packNormals(queue, in_order, normals_);
}

void PlaneIncrement::setSource(const std::vector<PlacedPoint>& source)
{
  source_points_ = source.size();
  lever_ = leverOf(viewOf(source));
}

double PlaneIncrement::rowNoise(const PlaneProblem& problem) const
{
  // A normal is no better than the points it comes of: their rounding along it, seen from a neighbour.
  const double spacing = surfaceSpacing(problem.length, source_points_);
  // The places of sum n n^T's diagonal in the upper triangle of six.
  const double squares[3] = {problem.sums[15], problem.sums[18], problem.sums[20]};
  const double weight = squares[0] + squares[1] + squares[2];
  double along_sq = 0;
  for (int axis = 0; axis < 3; ++axis)
    along_sq += weight > 0 ? squares[axis] / weight * rounding_[axis] * rounding_[axis] : 0;
  return std::hypot(std::sqrt(along_sq) / spacing, std::numeric_limits<float>::epsilon());
}

Estimate PlaneIncrement::estimate(opencl::Queue& queue,
                                  Precision precision,
                                  const stages::SourcePoints& source,
                                  const RigidTransform& pose,
                                  const opencl::Buffer& matches,
                                  const stages::TargetPoints& target)
{
  const bool is_double = precision == Precision::Double;
  const std::size_t real_bytes = is_double ? sizeof(double) : sizeof(float);
  PlaneProblem problem;
  problem.centre = pose(lever_.centre[0], lever_.centre[1], lever_.centre[2]);
  for (double& coordinate : problem.centre)
    coordinate = rounded<float>(coordinate);
  problem.length = lever_.length > 0 ? lever_.length : 1;

  queue.reserve(total_, PLANE_SUMS * real_bytes);
  stage_.enqueue(queue, source, pose, matches, target, normals_, problem.centre, real_bytes, total_);
  problem.sums = is_double ? download<double>(queue, total_) : download<float>(queue, total_);
  requireFinite(problem.sums, precision);
  problem.row_noise = rowNoise(problem);
  problem.sum_noise = 8 * (is_double ? std::numeric_limits<double>::epsilon() : std::numeric_limits<float>::epsilon());
  const double weight = problem.sums[15] + problem.sums[18] + problem.sums[20];
  mean_squared_distance_ = weight > 0 ? problem.sums[PLANE_SUMS - 1] / weight : 0;
  return solved(problem);
}

} // namespace pcl_gpu_icp
