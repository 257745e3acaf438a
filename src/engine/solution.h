#pragma once

#include "kernels/layout.h"

#include <pcl_gpu_icp/rigid_estimator.h>

#include <algorithm>

namespace pcl_gpu_icp {

/// Singular values that are more than rounding, as what they leave undetermined.
Degeneracy degeneracyOf(int rank);

/// What the device wrote, in double.
template <typename real>
void copySolution(const RigidSolution<real>& solution, Estimate& estimate)
{
  StageValues& values = estimate.stages;
  std::copy(std::begin(solution.source_centroid), std::end(solution.source_centroid), values.source_centroid.begin());
  std::copy(std::begin(solution.target_centroid), std::end(solution.target_centroid), values.target_centroid.begin());
  std::copy(std::begin(solution.H), std::end(solution.H), values.H.begin());
  std::copy(std::begin(solution.U), std::end(solution.U), values.U.begin());
  std::copy(std::begin(solution.S), std::end(solution.S), values.S.begin());
  std::copy(std::begin(solution.V), std::end(solution.V), values.V.begin());
  std::copy(std::begin(solution.R), std::end(solution.R), values.R.begin());
  std::copy(std::begin(solution.t), std::end(solution.t), values.t.begin());
  estimate.degeneracy = degeneracyOf(solution.rank);
}

/// \throws InvalidArgument when H, R or t overflowed
void requireFinite(const Estimate& estimate, Precision precision);
/// The same of normal equations.
void requireFinite(const std::array<double, SYSTEM_SUMS>& sums, Precision precision, Metric metric);

/// With each entry as float32 holds it.
RigidTransform inFloat(const RigidTransform& transform);

/// A pose and the frames it is used in on the device: about the clouds' pivots, in float32.
class DevicePose {
public:
  DevicePose(const RigidTransform& pose,
             const std::array<double, 3>& source_pivot,
             const std::array<double, 3>& target_pivot);

  /// From source about its pivot to target about its pivot; the entries are float32 values.
  const RigidTransform& pivoted() const { return pivoted_; }

  /// The increment to the pose itself, from an estimate between the source as the device moved it and the target. Sets
  /// the estimate's pivots: both clouds are in the target's frame by then.
  void completeIncrement(Estimate& estimate) const;

private:
  RigidTransform pose_, pivoted_;
  std::array<double, 3> source_pivot_, target_pivot_;
};

/// The transform in the callers' coordinates: t is derived from R in double, with the pivots put back.
RigidTransform absoluteTransform(const StageValues& values);

} // namespace pcl_gpu_icp
