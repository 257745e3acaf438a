#pragma once

#include <pcl_gpu_icp/device_transformation_estimation.h>
#include <pcl_gpu_icp/normal_estimator.h>
#include <pcl_gpu_icp/plane_estimator.h>

#include <pcl/point_cloud.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>

namespace pcl_gpu_icp {

/// pcl::registration::TransformationEstimationPointToPlaneLLS on an OpenCL device: the rigid motion that, linearised,
/// makes the distances from source points to the planes through their target points least (Low 2004). Fewer iterations
/// than point-to-point, on another path, to an alignment of the same quality. Given to
/// pcl_gpu_icp::IterativeClosestPoint by setTransformationEstimation() it takes the increment from the matching pass,
/// on the aligner's device; setDevice() here is for pairs that are listed.
///
/// Normals are those of the target's points, of either sign; for a point type without normals they are estimated on the
/// device from each point's nearest ones. Points with a normal that is not finite, or zero, take no part.
///
/// The small rotation turns about the source's centroid where PCL's turns about the origin: the answers differ by the
/// square of its angle, which is nothing at the end of an alignment. Motions that the planes leave undetermined are
/// left as they were and named in getEstimate() where PCL divides by nearly zero.
template <typename PointSource, typename PointTarget, typename Scalar = float>
class TransformationEstimationPointToPlaneLLS
: public DeviceTransformationEstimation<PointSource, PointTarget, Scalar, PlaneEstimator> {
public:
  using Ptr = pcl::shared_ptr<TransformationEstimationPointToPlaneLLS>;
  using ConstPtr = pcl::shared_ptr<const TransformationEstimationPointToPlaneLLS>;
  using Normals = NormalEstimator::Normals;
  /// Estimates a normal for each point, from so many of its nearest. The points have this fingerprint.
  using EstimateNormals = std::function<std::shared_ptr<const Normals>(
      const Points& points, std::uint64_t fingerprint, unsigned neighbours)>;

  TransformationEstimationPointToPlaneLLS();
  TransformationEstimationPointToPlaneLLS(const TransformationEstimationPointToPlaneLLS& other);
  TransformationEstimationPointToPlaneLLS& operator=(const TransformationEstimationPointToPlaneLLS& other);
  ~TransformationEstimationPointToPlaneLLS() override = default;

  /// How many points, itself among them, a normal is estimated from where the target has none: 20 by default.
  void setNumberOfNeighbours(unsigned neighbours);
  unsigned getNumberOfNeighbours() const;

  /// A normal for each point of `cloud`, estimated when the point type has none. Those estimated last are kept until
  /// the coordinates change.
  /// \param kept owns what the result views
  /// \throws what `estimate` throws
  Points normalsOf(const pcl::PointCloud<PointTarget>& cloud,
                   const EstimateNormals& estimate,
                   std::shared_ptr<const Normals>& kept) const;

private:
  std::unique_ptr<PlaneEstimator> makeEstimator(const Device& device) const override;
  Estimate estimate(PlaneEstimator& estimator,
                    const Points& source,
                    const Points& target,
                    const pcl::PointCloud<PointTarget>& cloud_tgt) const override;

  mutable std::mutex normals_mutex_; ///< guards what follows
  unsigned neighbours_ = NormalEstimator::default_neighbours;
  mutable std::shared_ptr<const Normals> normals_; ///< estimated last,
  mutable std::uint64_t normals_of_ = 0;           ///< and the fingerprint of the points they are of
};

} // namespace pcl_gpu_icp

#include <pcl_gpu_icp/impl/transformation_estimation_point_to_plane_lls.hpp>
