#pragma once

#include "match.h"

#include <pcl_gpu_icp/loss.h>
#include <pcl_gpu_icp/result.h>

#include <array>

namespace pcl_gpu_icp::stages {

/// What a metric knows of the points: normals of the target's (point-to-plane), or normals (symmetric) or covariances
/// (GICP) of both clouds'. See kernels/layout.h.
struct MetricPoints {
  opencl::Buffer target{"normals or covariances of the target"};
  opencl::Buffer source{"normals or covariances of the source"};
};

using Normal = std::array<float, NORMAL_ROWS>;
/// In the order of the leaves; those that are not finite become zero.
void packTargetNormals(opencl::Queue& queue, const std::vector<Normal>& normals, MetricPoints& own);
/// In the order of the source's rows; likewise.
void packSourceNormals(opencl::Queue& queue,
                       const std::vector<Normal>& normals,
                       const SourcePoints& source,
                       MetricPoints& own);

/// xx xy xz yy yz zz
using Covariance = std::array<float, COVARIANCE_ROWS>;
void packTargetCovariances(opencl::Queue& queue, const std::vector<Covariance>& covariances, MetricPoints& own);
/// In the order of the source's rows.
void packSourceCovariances(opencl::Queue& queue,
                           const std::vector<Covariance>& covariances,
                           const SourcePoints& source,
                           MetricPoints& own);

/// The normal equations of a metric over matched pairs. See kernels/system.h.
class System {
public:
  /// Writes SYSTEM_SUMS values.
  /// \param pose from the source's frame (about its pivot) to the target's
  /// \param turn the pose whose rotation the pairs are weighed by
  /// \param matches as Match::matches()
  /// \param centre in the target's frame; float32 values
  /// \param loss with its scale
  /// \param keeps_residuals residuals() are those of this launch
  void enqueue(opencl::Queue& queue,
               Metric metric,
               const SourcePoints& source,
               const RigidTransform& pose,
               const RigidTransform& turn,
               const opencl::Buffer& matches,
               const TargetPoints& target,
               const MetricPoints& own,
               const std::array<double, 3>& centre,
               const Loss& loss,
               bool keeps_residuals,
               std::size_t real_bytes,
               const opencl::Buffer& total);

  /// A float for each of the source's rows; infinite: there is no pair.
  const opencl::Buffer& residuals() const { return residuals_; }

private:
  opencl::Buffer residuals_{"residuals"};
  opencl::Buffer partials_{"partial sums of normal equations"};
};

} // namespace pcl_gpu_icp::stages
