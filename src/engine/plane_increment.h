#pragma once

#include "plane_solution.h"
#include "stages/plane.h"

#include <pcl_gpu_icp/icp_loop.h>
#include <pcl_gpu_icp/points.h>

#include <vector>

namespace pcl_gpu_icp {

/// Point-to-plane estimation for clouds on the device.
class PlaneIncrement {
public:
  /// \param target the points in the order of the leaves
  /// \param pivot what they are about
  /// \param normals of the caller's points, which PlacedPoint::position counts; those that are not finite take no part
  void setNormals(opencl::Queue& queue,
                  const std::vector<PlacedPoint>& target,
                  const std::array<double, 3>& pivot,
                  const Points& normals);

  void setSource(const std::vector<PlacedPoint>& source);

  /// The increment in the target's frame, about the target's pivot; `pairs` is left to the caller.
  /// \param pose from the source's frame (about its pivot) to the target's
  /// \throws InvalidArgument when the sums overflowed
  Estimate estimate(opencl::Queue& queue,
                    Precision precision,
                    const stages::SourcePoints& source,
                    const RigidTransform& pose,
                    const opencl::Buffer& matches,
                    const stages::TargetPoints& target);

  /// Mean square, over the last estimate's pairs with a normal, of the distance from source point to plane.
  double meanSquaredDistance() const { return mean_squared_distance_; }

private:
  double rowNoise(const PlaneProblem& problem) const;

  Lever lever_; ///< of the source about its pivot
  std::size_t source_points_ = 0;
  std::array<double, 3> rounding_{}; ///< half a unit in the last place of the target's largest coordinates
  opencl::Buffer normals_{"normals"};
  stages::Plane stage_;
  opencl::Buffer total_{"point-to-plane sums"};
  double mean_squared_distance_ = 0;
};

} // namespace pcl_gpu_icp
