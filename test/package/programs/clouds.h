#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Core>

#include <cmath>

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

const Eigen::Vector3f shift(0.02F, -0.01F, 0.03F);

/// Hills, moved by so much.
inline Cloud::Ptr hills(const Eigen::Vector3f& by = Eigen::Vector3f::Zero())
{
  Cloud::Ptr cloud(new Cloud);
  for (int x = 0; x < 25; ++x)
    for (int y = 0; y < 25; ++y) {
      const float u = 0.1F * static_cast<float>(x), v = 0.1F * static_cast<float>(y);
      cloud->emplace_back(u + by.x(), v + by.y(), std::sin(2 * u) * std::cos(3 * v) + by.z());
    }
  return cloud;
}

/// Whether an aligner with hills() as its target and hills(shift) as its source finds the shift.
template <typename Icp>
bool findsTheShift(Icp& icp)
{
  icp.setMaximumIterations(50);
  icp.setTransformationEpsilon(1e-12);
  Cloud aligned;
  icp.align(aligned);
  const Eigen::Vector3f found = icp.getFinalTransformation().template topRightCorner<3, 1>();
  return icp.hasConverged() && (found + shift).norm() < 1e-3F && aligned.size() == hills()->size();
}
