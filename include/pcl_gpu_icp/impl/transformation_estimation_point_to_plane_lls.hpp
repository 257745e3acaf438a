#pragma once

#include <pcl_gpu_icp/search/nearest_index.h>
#include <pcl_gpu_icp/search/points_of.h>
#include <pcl_gpu_icp/transformation_estimation_point_to_plane_lls.h>

#include <pcl/point_types.h>

namespace pcl_gpu_icp {

template <typename PointSource, typename PointTarget, typename Scalar>
TransformationEstimationPointToPlaneLLS<PointSource, PointTarget, Scalar>::TransformationEstimationPointToPlaneLLS()
: DeviceTransformationEstimation<PointSource, PointTarget, Scalar, PlaneEstimator>(
      "TransformationEstimationPointToPlaneLLS")
{
}

template <typename PointSource, typename PointTarget, typename Scalar>
TransformationEstimationPointToPlaneLLS<PointSource, PointTarget, Scalar>::TransformationEstimationPointToPlaneLLS(
    const TransformationEstimationPointToPlaneLLS& other)
: DeviceTransformationEstimation<PointSource, PointTarget, Scalar, PlaneEstimator>(other)
{
  *this = other;
}

template <typename PointSource, typename PointTarget, typename Scalar>
TransformationEstimationPointToPlaneLLS<PointSource, PointTarget, Scalar>&
TransformationEstimationPointToPlaneLLS<PointSource, PointTarget, Scalar>::operator=(
    const TransformationEstimationPointToPlaneLLS& other)
{
  if (this == &other)
    return *this;
  DeviceTransformationEstimation<PointSource, PointTarget, Scalar, PlaneEstimator>::operator=(other);
  const std::scoped_lock lock(normals_mutex_, other.normals_mutex_);
  neighbours_ = other.neighbours_;
  normals_ = other.normals_;
  normals_of_ = other.normals_of_;
  return *this;
}

template <typename PointSource, typename PointTarget, typename Scalar>
void TransformationEstimationPointToPlaneLLS<PointSource, PointTarget, Scalar>::setNumberOfNeighbours(
    unsigned neighbours)
{
  const std::lock_guard<std::mutex> lock(normals_mutex_);
  neighbours_ = neighbours;
  normals_.reset();
}

template <typename PointSource, typename PointTarget, typename Scalar>
unsigned TransformationEstimationPointToPlaneLLS<PointSource, PointTarget, Scalar>::getNumberOfNeighbours() const
{
  const std::lock_guard<std::mutex> lock(normals_mutex_);
  return neighbours_;
}

template <typename PointSource, typename PointTarget, typename Scalar>
Points TransformationEstimationPointToPlaneLLS<PointSource, PointTarget, Scalar>::normalsOf(
    const pcl::PointCloud<PointTarget>& cloud,
    [[maybe_unused]] const EstimateNormals& estimate,
    [[maybe_unused]] std::shared_ptr<const Normals>& kept) const
{
  if constexpr (pcl::traits::has_normal<PointTarget>::value)
    return search::normalsOf(cloud);
  else {
    Points normals = search::pointsOf(cloud);
    const std::uint64_t fingerprint = search::fingerprintOf(normals);
    const std::lock_guard<std::mutex> lock(normals_mutex_);
    if (!normals_ || normals_of_ != fingerprint) {
      normals_ = estimate(normals, fingerprint, neighbours_);
      normals_of_ = fingerprint;
    }
    kept = normals_;
    normals.data = kept->data();
    normals.stride = sizeof(Normals::value_type);
    return normals;
  }
}

template <typename PointSource, typename PointTarget, typename Scalar>
std::unique_ptr<PlaneEstimator>
TransformationEstimationPointToPlaneLLS<PointSource, PointTarget, Scalar>::makeEstimator(const Device& device) const
{
  return std::make_unique<PlaneEstimator>(device, detail::precisionFor<Scalar>(device));
}

template <typename PointSource, typename PointTarget, typename Scalar>
Estimate TransformationEstimationPointToPlaneLLS<PointSource, PointTarget, Scalar>::estimate(
    PlaneEstimator& estimator,
    const Points& source,
    const Points& target,
    const pcl::PointCloud<PointTarget>& cloud_tgt) const
{
  std::shared_ptr<const Normals> kept;
  const auto estimate_normals = [this](const Points& points, std::uint64_t /*fingerprint*/, unsigned neighbours) {
    const Device& device = this->getDevice();
    NormalEstimator normal_estimator(device, detail::precisionFor<Scalar>(device));
    return std::make_shared<const Normals>(normal_estimator.estimate(points, neighbours));
  };
  Points normals = normalsOf(cloud_tgt, estimate_normals, kept);
  normals.count = target.count;
  normals.index = target.index;
  normals.index_stride = target.index_stride;
  return estimator.estimate(source, target, normals);
}

} // namespace pcl_gpu_icp
