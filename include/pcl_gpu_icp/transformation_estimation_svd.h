#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/rigid_estimator.h>

#include <pcl/registration/transformation_estimation.h>

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace pcl_gpu_icp {

/// pcl::registration::TransformationEstimationSVD with its five stages on an OpenCL device: the least-squares rigid
/// transform from matched source points to target points. Any point types with x, y, z. Pairs with a non-finite point
/// do not take part. Usable in any PCL pipeline through setTransformationEstimation(). const and thread-safe: threads
/// that estimate at the same time use queues of their own.
///
/// Errors: sizes that differ are reported through PCL_ERROR and leave the matrix as it was, as in PCL. A failure of
/// the device is a DeviceError.
template <typename PointSource, typename PointTarget, typename Scalar = float>
class TransformationEstimationSVD
: public pcl::registration::TransformationEstimation<PointSource, PointTarget, Scalar> {
public:
  using Ptr = pcl::shared_ptr<TransformationEstimationSVD>;
  using ConstPtr = pcl::shared_ptr<const TransformationEstimationSVD>;
  using Matrix4 = typename pcl::registration::TransformationEstimation<PointSource, PointTarget, Scalar>::Matrix4;

  /// \param use_umeyama accepted for compatibility; both of PCL's paths compute what the device computes
  explicit TransformationEstimationSVD(bool use_umeyama = true);
  ~TransformationEstimationSVD() override = default;

  /// The device to run on; by default Device::select(), on first use.
  void setDevice(const Device& device);
  /// The device that runs or will run the stages.
  /// \throws DeviceError when none was set and none is there
  Device getDevice() const;

  /// Pipeline::Fused by default.
  void setPipeline(Pipeline pipeline);
  Pipeline getPipeline() const { return pipeline_; }

  /// Pairs (cloud_src[i], cloud_tgt[i]).
  void estimateRigidTransformation(const pcl::PointCloud<PointSource>& cloud_src,
                                   const pcl::PointCloud<PointTarget>& cloud_tgt,
                                   Matrix4& transformation_matrix) const override;

  /// Pairs (cloud_src[indices_src[i]], cloud_tgt[i]).
  void estimateRigidTransformation(const pcl::PointCloud<PointSource>& cloud_src,
                                   const pcl::Indices& indices_src,
                                   const pcl::PointCloud<PointTarget>& cloud_tgt,
                                   Matrix4& transformation_matrix) const override;

  /// Pairs (cloud_src[indices_src[i]], cloud_tgt[indices_tgt[i]]).
  void estimateRigidTransformation(const pcl::PointCloud<PointSource>& cloud_src,
                                   const pcl::Indices& indices_src,
                                   const pcl::PointCloud<PointTarget>& cloud_tgt,
                                   const pcl::Indices& indices_tgt,
                                   Matrix4& transformation_matrix) const override;

  /// Pairs (cloud_src[c.index_query], cloud_tgt[c.index_match]).
  void estimateRigidTransformation(const pcl::PointCloud<PointSource>& cloud_src,
                                   const pcl::PointCloud<PointTarget>& cloud_tgt,
                                   const pcl::Correspondences& correspondences,
                                   Matrix4& transformation_matrix) const override;

  /// What the stages computed in the last estimate that ended.
  Estimate getEstimate() const;

private:
  void estimate(const Points& source, const Points& target, Matrix4& transformation_matrix) const;

  Pipeline pipeline_ = Pipeline::Fused;
  mutable std::mutex mutex_; ///< guards what follows
  mutable std::optional<Device> device_;
  mutable std::vector<std::unique_ptr<RigidEstimator>> idle_estimators_;
  mutable Estimate last_estimate_;
};

} // namespace pcl_gpu_icp

#include <pcl_gpu_icp/impl/transformation_estimation_svd.hpp>
