#pragma once

#include <pcl_gpu_icp/device_transformation_estimation.h>
#include <pcl_gpu_icp/error.h>
#include <pcl_gpu_icp/impl/matrix.hpp>
#include <pcl_gpu_icp/search/points_of.h>

#include <pcl/console/print.h>

#include <limits>
#include <type_traits>

namespace pcl_gpu_icp {

namespace detail {

/// Sums in double where the caller's scalar is double, and on CPUs, where double costs nothing.
template <typename Scalar>
Precision precisionFor(const Device& device)
{
  const bool wanted = std::is_same<Scalar, double>::value || device.info().type == DeviceInfo::Type::Cpu;
  return wanted && device.info().fp64 ? Precision::Double : Precision::Float;
}

/// The points of a cloud that one member of the correspondences names.
template <typename PointT>
Points matchedPoints(const pcl::PointCloud<PointT>& cloud,
                     const pcl::Correspondences& correspondences,
                     pcl::index_t pcl::Correspondence::*member)
{
  Points points = search::pointsOf(cloud);
  points.count = correspondences.size();
  points.index = correspondences.empty() ? nullptr : &(correspondences[0].*member);
  points.index_stride = sizeof(pcl::Correspondence);
  return points;
}

} // namespace detail

template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>::DeviceTransformationEstimation(
    const DeviceTransformationEstimation& other)
: pcl::registration::TransformationEstimation<PointSource, PointTarget, Scalar>(other)
, name_(other.name_)
{
  *this = other;
}

template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>&
DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>::operator=(
    const DeviceTransformationEstimation& other)
{
  if (this == &other)
    return *this;
  const std::scoped_lock lock(mutex_, other.mutex_);
  device_ = other.device_;
  last_estimate_ = other.last_estimate_;
  idle_estimators_.clear();
  return *this;
}

template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
void DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>::setDevice(const Device& device)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  device_ = device;
  idle_estimators_.clear();
}

template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
Device DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>::getDevice() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!device_)
    device_ = Device::select();
  return *device_;
}

template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
void DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>::forgetEstimators()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  idle_estimators_.clear();
}

template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
Estimate DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>::getEstimate() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return last_estimate_;
}

template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
void DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>::estimate(
    const Points& source,
    const Points& target,
    const pcl::PointCloud<PointTarget>& cloud_tgt,
    Matrix4& transformation_matrix) const
{
  const Device device = getDevice();
  std::unique_ptr<Estimator> estimator;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!idle_estimators_.empty()) {
      estimator = std::move(idle_estimators_.back());
      idle_estimators_.pop_back();
    }
  }
  if (!estimator)
    estimator = makeEstimator(device);

  const Estimate found = estimate(*estimator, source, target, cloud_tgt);
  transformation_matrix = detail::toMatrix<Scalar>(rounded<Scalar>(found.transform, found.sourceCentroid()));

  const std::lock_guard<std::mutex> lock(mutex_);
  last_estimate_ = found;
  idle_estimators_.push_back(std::move(estimator));
}

template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
void DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>::estimateRigidTransformation(
    const pcl::PointCloud<PointSource>& cloud_src,
    const pcl::PointCloud<PointTarget>& cloud_tgt,
    Matrix4& transformation_matrix) const
{
  if (sameSize("points", cloud_src.size(), cloud_tgt.size()))
    estimate(search::pointsOf(cloud_src), search::pointsOf(cloud_tgt), cloud_tgt, transformation_matrix);
}

template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
void DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>::estimateRigidTransformation(
    const pcl::PointCloud<PointSource>& cloud_src,
    const pcl::Indices& indices_src,
    const pcl::PointCloud<PointTarget>& cloud_tgt,
    Matrix4& transformation_matrix) const
{
  if (sameSize("points", indices_src.size(), cloud_tgt.size()))
    estimate(search::pointsOf(cloud_src, &indices_src), search::pointsOf(cloud_tgt), cloud_tgt, transformation_matrix);
}

template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
void DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>::estimateRigidTransformation(
    const pcl::PointCloud<PointSource>& cloud_src,
    const pcl::Indices& indices_src,
    const pcl::PointCloud<PointTarget>& cloud_tgt,
    const pcl::Indices& indices_tgt,
    Matrix4& transformation_matrix) const
{
  if (sameSize("indices", indices_src.size(), indices_tgt.size()))
    estimate(search::pointsOf(cloud_src, &indices_src),
             search::pointsOf(cloud_tgt, &indices_tgt),
             cloud_tgt,
             transformation_matrix);
}

template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
void DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>::estimateRigidTransformation(
    const pcl::PointCloud<PointSource>& cloud_src,
    const pcl::PointCloud<PointTarget>& cloud_tgt,
    const pcl::Correspondences& correspondences,
    Matrix4& transformation_matrix) const
{
  estimate(detail::matchedPoints(cloud_src, correspondences, &pcl::Correspondence::index_query),
           detail::matchedPoints(cloud_tgt, correspondences, &pcl::Correspondence::index_match),
           cloud_tgt,
           transformation_matrix);
}

template <typename PointSource, typename PointTarget, typename Scalar, typename Estimator>
bool DeviceTransformationEstimation<PointSource, PointTarget, Scalar, Estimator>::sameSize(const char* what,
                                                                                           std::size_t source,
                                                                                           std::size_t target) const
{
  if (source == target)
    return true;
  PCL_ERROR("[pcl_gpu_icp::%s::estimateRigidTransformation] Number of %s in source (%zu) differs from target (%zu)!\n",
            name_,
            what,
            source,
            target);
  return false;
}

} // namespace pcl_gpu_icp
