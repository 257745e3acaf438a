#pragma once

#include <pcl_gpu_icp/device_transformation_estimation.h>

#include <pcl/point_cloud.h>

#include <memory>

namespace pcl_gpu_icp {

/// pcl::registration::TransformationEstimationSVD with its five stages on an OpenCL device: the least-squares rigid
/// transform from matched source points to target points. Any point types with x, y, z. Pairs with a non-finite point
/// do not take part.
template <typename PointSource, typename PointTarget, typename Scalar = float>
class TransformationEstimationSVD
: public DeviceTransformationEstimation<PointSource, PointTarget, Scalar, RigidEstimator> {
public:
  using Ptr = pcl::shared_ptr<TransformationEstimationSVD>;
  using ConstPtr = pcl::shared_ptr<const TransformationEstimationSVD>;

  /// \param use_umeyama accepted for compatibility; both of PCL's paths compute what the device computes
  explicit TransformationEstimationSVD(bool use_umeyama = true);
  ~TransformationEstimationSVD() override = default;

  /// Pipeline::Fused by default.
  void setPipeline(Pipeline pipeline);
  Pipeline getPipeline() const { return pipeline_; }

private:
  std::unique_ptr<RigidEstimator> makeEstimator(const Device& device) const override;
  Estimate estimate(RigidEstimator& estimator,
                    const Points& source,
                    const Points& target,
                    const pcl::PointCloud<PointTarget>& cloud_tgt) const override;

  Pipeline pipeline_ = Pipeline::Fused;
};

} // namespace pcl_gpu_icp

#include <pcl_gpu_icp/impl/transformation_estimation_svd.hpp>
