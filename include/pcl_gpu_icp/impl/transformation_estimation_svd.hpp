#pragma once

#include <pcl_gpu_icp/transformation_estimation_svd.h>

namespace pcl_gpu_icp {

template <typename PointSource, typename PointTarget, typename Scalar>
TransformationEstimationSVD<PointSource, PointTarget, Scalar>::TransformationEstimationSVD(bool /*use_umeyama*/)
: DeviceTransformationEstimation<PointSource, PointTarget, Scalar, RigidEstimator>("TransformationEstimationSVD")
{
}

template <typename PointSource, typename PointTarget, typename Scalar>
void TransformationEstimationSVD<PointSource, PointTarget, Scalar>::setPipeline(Pipeline pipeline)
{
  pipeline_ = pipeline;
  this->forgetEstimators();
}

template <typename PointSource, typename PointTarget, typename Scalar>
std::unique_ptr<RigidEstimator>
TransformationEstimationSVD<PointSource, PointTarget, Scalar>::makeEstimator(const Device& device) const
{
  return std::make_unique<RigidEstimator>(device, pipeline_, detail::precisionFor<Scalar>(device));
}

template <typename PointSource, typename PointTarget, typename Scalar>
Estimate TransformationEstimationSVD<PointSource, PointTarget, Scalar>::estimate(
    RigidEstimator& estimator,
    const Points& source,
    const Points& target,
    const pcl::PointCloud<PointTarget>& /*cloud_tgt*/) const
{
  return estimator.estimate(source, target);
}

} // namespace pcl_gpu_icp
