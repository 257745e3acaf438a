#include "solution.h"

#include <pcl_gpu_icp/error.h>

#include <cmath>

namespace pcl_gpu_icp {

namespace {

template <std::size_t n>
bool allFinite(const std::array<double, n>& values)
{
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

void requireFinite(bool finite, Precision precision, const char* or_else)
{
  if (!finite)
    throw InvalidArgument("the pairs' coordinates are too large to be multiplied in " +
                          std::string(toString(precision)) + ", or " + or_else);
}

constexpr char not_finite[] = "a correspondence names a point that is not finite";

std::array<double, 3> negated(const std::array<double, 3>& x) { return {-x[0], -x[1], -x[2]}; }

} // namespace

Degeneracy degeneracyOf(int rank)
{
  return rank >= 2 ? Degeneracy::None : rank == 1 ? Degeneracy::Line : Degeneracy::Point;
}

void requireFinite(const Estimate& estimate, Precision precision)
{
  requireFinite(allFinite(estimate.stages.H) && allFinite(estimate.stages.R) && allFinite(estimate.stages.t),
                precision,
                not_finite);
}

void requireFinite(const std::array<double, SYSTEM_SUMS>& sums, Precision precision, Metric metric)
{
  requireFinite(allFinite(sums),
                precision,
                metric == Metric::Generalized ? "the sum of a pair's covariances has no inverse" : not_finite);
}

RigidTransform absoluteTransform(const StageValues& values)
{
  std::array<double, 3> p{}, q{};
  for (int i = 0; i < 3; ++i) {
    p[i] = values.source_centroid[i] + values.source_pivot[i];
    q[i] = values.target_centroid[i] + values.target_pivot[i];
  }
  RigidTransform transform = nearestRigid({values.R, {}}, {});
  const auto rotated = transform(p[0], p[1], p[2]);
  for (int i = 0; i < 3; ++i)
    transform.translation[i] = q[i] - rotated[i];
  return transform;
}

RigidTransform inFloat(const RigidTransform& transform)
{
  RigidTransform result = transform;
  for (double& entry : result.rotation)
    entry = rounded<float>(entry);
  for (double& entry : result.translation)
    entry = rounded<float>(entry);
  return result;
}

DevicePose::DevicePose(const RigidTransform& pose,
                       const std::array<double, 3>& source_pivot,
                       const std::array<double, 3>& target_pivot)
: pose_(pose)
, pivoted_(inFloat(recentred(pose, source_pivot, target_pivot)))
, source_pivot_(source_pivot)
, target_pivot_(target_pivot)
{
}

void DevicePose::completeIncrement(Estimate& estimate) const
{
  estimate.stages.source_pivot = estimate.stages.target_pivot = target_pivot_;
  if (estimate.pairs == 0)
    return;
  // The device moved the source by the pose as float holds it, which is a rotation to float's digits; the increment is
  // to the pose itself, and a rotation to double's. The pairs' centroid stays where it is.
  const RigidTransform moved_by = recentred(pivoted_, negated(source_pivot_), negated(target_pivot_));
  const auto centroid = estimate.sourceCentroid();
  const auto original = inverse(moved_by)(centroid[0], centroid[1], centroid[2]);
  estimate.transform = nearestRigid(compose(absoluteTransform(estimate.stages), compose(moved_by, inverse(pose_))),
                                    pose_(original[0], original[1], original[2]));
}

} // namespace pcl_gpu_icp
