#pragma once

#include "stages/system.h"
#include "system_solution.h"

#include <pcl_gpu_icp/icp_loop.h>
#include <pcl_gpu_icp/loss.h>
#include <pcl_gpu_icp/motions.h>
#include <pcl_gpu_icp/points.h>

#include <optional>
#include <vector>

namespace pcl_gpu_icp {

class PointPairs;

/// What pairs weigh, and what an increment is sought among.
struct Objective {
  Loss loss;
  Motions motions = Motions::Rigid;
  int steps = 20; ///< towards the minimum, at most

  /// Whether point-to-point has its closed solution.
  bool isPlain() const;
};

/// Estimation by six normal equations, for clouds on the device.
class SystemIncrement {
public:
  /// Point-to-point. As setTargetNormals().
  void setPoints(const std::vector<PlacedPoint>& target, const std::array<double, 3>& pivot);

  /// Point-to-plane.
  /// \param target the points in the order of the leaves
  /// \param pivot what they are about
  /// \param normals of the caller's points, which PlacedPoint::position counts; those that are not finite take no part
  void setTargetNormals(opencl::Queue& queue,
                        const std::vector<PlacedPoint>& target,
                        const std::array<double, 3>& pivot,
                        const Points& normals);

  /// Makes point-to-plane the symmetric objective. As setSourceCovariances().
  void setSourceNormals(opencl::Queue& queue,
                        const std::vector<stages::Normal>& in_order,
                        const stages::SourcePoints& source);

  /// GICP, with setSourceCovariances(). As setTargetNormals(); `covariances` are COVARIANCE_ROWS floats each.
  void setTargetCovariances(opencl::Queue& queue,
                            const std::vector<PlacedPoint>& target,
                            const std::array<double, 3>& pivot,
                            const Points& covariances);

  /// Forgets the normals or covariances of the one before.
  void setSource(const std::vector<PlacedPoint>& source);

  /// \param in_order of the source's rows
  void setSourceCovariances(opencl::Queue& queue,
                            const std::vector<stages::Covariance>& in_order,
                            const stages::SourcePoints& source);

  Metric metric() const { return metric_; }

  /// The increment in the target's frame, about the target's pivot; `pairs` is left to the caller. Point-to-plane's is
  /// the linearised one (Low 2004), and so is the symmetric objective's (Rusinkiewicz 2019); the others' is, for the
  /// pairs and their information, the minimum (Gauss-Newton; with a loss iteratively reweighted).
  ///
  /// \param pose from the source's frame (about its pivot) to the target's
  /// \throws InvalidArgument when the sums overflowed, or what a metric knows of the source is not there
  Estimate estimate(opencl::Queue& queue,
                    Precision precision,
                    const stages::SourcePoints& source,
                    const RigidTransform& pose,
                    const opencl::Buffer& matches,
                    const stages::TargetPoints& target,
                    const Objective& objective = {});

  /// Of such pairs at a pose; none where they are too few.
  /// \param points the same pairs, as points
  /// \param spacing of the target's points
  std::optional<Uncertainty> uncertainty(opencl::Queue& queue,
                                         Precision precision,
                                         const stages::SourcePoints& source,
                                         const RigidTransform& pose,
                                         const opencl::Buffer& matches,
                                         const stages::TargetPoints& target,
                                         const Objective& objective,
                                         const PointPairs& points,
                                         double spacing);

  /// Of the last estimate's pairs, at the pose, in the clouds' unit squared: the mean square of the distance between
  /// points or from source point to plane (over those with a normal), or the squared distances' mean weighed by the
  /// pairs' information. With a loss of what it makes of them.
  double meanSquaredDistance() const { return mean_squared_distance_; }

  /// Of the last estimate's loss; 0 where there was none.
  double lossScale() const { return loss_scale_; }

private:
  /// \param residuals a sample of those at the pose; null: they are not asked for
  System systemAt(opencl::Queue& queue,
                  Precision precision,
                  const stages::SourcePoints& source,
                  const RigidTransform& pose,
                  const RigidTransform& turn,
                  const opencl::Buffer& matches,
                  const stages::TargetPoints& target,
                  const Objective& objective,
                  std::vector<float>* residuals = nullptr);
  double rowNoise(const System& system) const;
  void measureRounding(const std::vector<PlacedPoint>& target, const std::array<double, 3>& pivot);

  Metric metric_ = Metric::Point;
  double tangential_ = 0; ///< the share of a pair's information that is along the surface; GICP
  Lever lever_;           ///< of the source about its pivot
  std::size_t source_points_ = 0, source_surfaces_ = 0; ///< normals or covariances
  std::array<double, 3> rounding_{}; ///< half a unit in the last place of the target's largest coordinates
  stages::MetricPoints own_;
  stages::System stage_;
  opencl::Buffer total_{"normal equations"};
  double mean_squared_distance_ = 0, loss_scale_ = 0;
};

} // namespace pcl_gpu_icp
