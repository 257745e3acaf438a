#pragma once

#include "stages/system.h"
#include "system_solution.h"

#include <pcl_gpu_icp/icp_loop.h>
#include <pcl_gpu_icp/points.h>

#include <vector>

namespace pcl_gpu_icp {

/// Estimation by six normal equations, for clouds on the device: point-to-plane and GICP.
class SystemIncrement {
public:
  /// Point-to-plane.
  /// \param target the points in the order of the leaves
  /// \param pivot what they are about
  /// \param normals of the caller's points, which PlacedPoint::position counts; those that are not finite take no part
  void setNormals(opencl::Queue& queue,
                  const std::vector<PlacedPoint>& target,
                  const std::array<double, 3>& pivot,
                  const Points& normals);

  /// GICP, with setSourceCovariances(). As setNormals(); `covariances` are COVARIANCE_ROWS floats each.
  void setTargetCovariances(opencl::Queue& queue,
                            const std::vector<PlacedPoint>& target,
                            const std::array<double, 3>& pivot,
                            const Points& covariances);

  /// Forgets the covariances of the one before.
  void setSource(const std::vector<PlacedPoint>& source);

  /// \param in_order of the source's rows
  void setSourceCovariances(opencl::Queue& queue,
                            const std::vector<stages::Covariance>& in_order,
                            const stages::SourcePoints& source);

  Metric metric() const { return metric_; }

  /// The increment in the target's frame, about the target's pivot; `pairs` is left to the caller. Point-to-plane's is
  /// the linearised one (Low 2004); GICP's is, for the pairs and their weights, the minimum (Gauss-Newton).
  /// \param pose from the source's frame (about its pivot) to the target's
  /// \throws InvalidArgument when the sums overflowed, or GICP has no covariances of the source
  Estimate estimate(opencl::Queue& queue,
                    Precision precision,
                    const stages::SourcePoints& source,
                    const RigidTransform& pose,
                    const opencl::Buffer& matches,
                    const stages::TargetPoints& target);

  /// Of the last estimate's pairs, at the pose, in the clouds' unit squared: the mean square of the distance from
  /// source point to plane (over those with a normal), or the squared distances' mean weighed by the pairs'
  /// information.
  double meanSquaredDistance() const { return mean_squared_distance_; }

private:
  System systemAt(opencl::Queue& queue,
                  Precision precision,
                  const stages::SourcePoints& source,
                  const RigidTransform& pose,
                  const RigidTransform& turn,
                  const opencl::Buffer& matches,
                  const stages::TargetPoints& target);
  double rowNoise(const System& system) const;
  void measureRounding(const std::vector<PlacedPoint>& target, const std::array<double, 3>& pivot);

  Metric metric_ = Metric::Plane;
  Lever lever_; ///< of the source about its pivot
  std::size_t source_points_ = 0, source_covariances_ = 0;
  std::array<double, 3> rounding_{}; ///< half a unit in the last place of the target's largest coordinates
  stages::MetricPoints own_;
  stages::System stage_;
  opencl::Buffer total_{"normal equations"};
  double mean_squared_distance_ = 0;
};

} // namespace pcl_gpu_icp
