#pragma once

#include <pcl/common/transforms.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>

#include <cmath>
#include <random>

namespace scenes {

/// A surface of hills, 4 x 4 m, sampled at random. The same seed gives the same cloud.
template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr hills(std::size_t points, unsigned seed = 1)
{
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> plane(-2.0F, 2.0F);
  typename pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>);
  for (std::size_t i = 0; i < points; ++i) {
    PointT point;
    point.x = plane(generator);
    point.y = plane(generator);
    point.z = 0.4F * std::sin(1.7F * point.x) * std::cos(1.3F * point.y) + 0.2F * point.x * point.y;
    cloud->push_back(point);
  }
  return cloud;
}

template <typename PointT>
typename pcl::PointCloud<PointT>::Ptr moved(const pcl::PointCloud<PointT>& cloud, const Eigen::Affine3f& by)
{
  typename pcl::PointCloud<PointT>::Ptr result(new pcl::PointCloud<PointT>(cloud));
  for (auto& point : *result)
    point.getVector3fMap() = by * Eigen::Vector3f(point.getVector3fMap());
  return result;
}

/// A few degrees and centimetres: within reach of ICP on hills().
inline Eigen::Affine3f smallMotion()
{
  return Eigen::Translation3f(0.05F, -0.04F, 0.03F) * Eigen::AngleAxisf(0.06F, Eigen::Vector3f(1, 2, 3).normalized());
}

/// Rotation between two transforms, in degrees.
template <typename Scalar>
double degreesBetween(const Eigen::Matrix<Scalar, 4, 4>& a, const Eigen::Matrix<Scalar, 4, 4>& b)
{
  const Eigen::Matrix3d difference = a.template topLeftCorner<3, 3>().template cast<double>().transpose() *
                                     b.template topLeftCorner<3, 3>().template cast<double>();
  // |R - R^T| is 2 sqrt(2) sin: exact for small angles, where the cosine is not.
  return (difference - difference.transpose()).norm() / (2 * std::sqrt(2.0)) * 180.0 / M_PI;
}

/// Distance between the translations of two transforms.
template <typename Scalar>
double metresBetween(const Eigen::Matrix<Scalar, 4, 4>& a, const Eigen::Matrix<Scalar, 4, 4>& b)
{
  return (a - b).template topRightCorner<3, 1>().norm();
}

} // namespace scenes
