#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_estimator.h>

#include <pcl/registration/transformation_estimation.h>

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace pcl_gpu_icp {

/// What the estimators for PCL have in common: a pcl::registration::TransformationEstimation that runs on an OpenCL
/// device, usable in any PCL pipeline through setTransformationEstimation(). const and thread-safe: threads that
/// estimate at the same time use queues of their own.
///
/// Errors: sizes that differ are reported through PCL_ERROR and leave the matrix as it was, as in PCL. A failure of
/// the device is a DeviceError.
/// \tparam Estimator of the engine
template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
class DeviceTransformationEstimation
: public pcl::registration::TransformationEstimation<PointSource, PointTarget, Scalar> {
public:
  using Matrix4 = typename pcl::registration::TransformationEstimation<PointSource, PointTarget, Scalar>::Matrix4;

  /// A copy has the settings, and estimates by itself.
  DeviceTransformationEstimation(const DeviceTransformationEstimation& other);
  DeviceTransformationEstimation& operator=(const DeviceTransformationEstimation& other);
  ~DeviceTransformationEstimation() override = default;

  /// The device to run on; by default Device::select(), on first use.
  void setDevice(const Device& device);
  /// The device that runs or will run the stages.
  /// \throws DeviceError when none was set and none is there
  Device getDevice() const;

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

  /// What was computed in the last estimate that ended.
  Estimate getEstimate() const;

protected:
  /// \param name of the class, for messages
  explicit DeviceTransformationEstimation(const char* name)
  : name_(name)
  {
  }

  /// The estimators made so far serve no more: new ones may be set up otherwise.
  void forgetEstimators();

private:
  virtual std::unique_ptr<Estimator> makeEstimator(const Device& device) const = 0;

  /// From pairs (source[i], target[i]); `cloud_tgt` is what the target points are of.
  virtual Estimate estimate(Estimator& estimator,
                            const Points& source,
                            const Points& target,
                            const pcl::PointCloud<PointTarget>& cloud_tgt) const = 0;

  void estimate(const Points& source,
                const Points& target,
                const pcl::PointCloud<PointTarget>& cloud_tgt,
                Matrix4& transformation_matrix) const;
  bool sameSize(const char* what, std::size_t source, std::size_t target) const;

  const char* name_;
  mutable std::mutex mutex_; ///< guards what follows
  mutable std::optional<Device> device_;
  mutable std::vector<std::unique_ptr<Estimator>> idle_estimators_;
  mutable Estimate last_estimate_;
};

} // namespace pcl_gpu_icp

#include <pcl_gpu_icp/impl/device_transformation_estimation.hpp>
