#pragma once

#include <pcl_gpu_icp/points.h>

#include <pcl/point_cloud.h>
#include <pcl/types.h>

namespace pcl_gpu_icp::search {

/// A view of a PCL cloud's coordinates, or of those that an index names.
template <typename PointT>
Points pointsOf(const pcl::PointCloud<PointT>& cloud, const pcl::Indices* indices = nullptr)
{
  Points points;
  points.data = cloud.empty() ? nullptr : &cloud[0].x;
  points.stride = sizeof(PointT);
  points.count = indices ? indices->size() : cloud.size();
  points.index = indices ? indices->data() : nullptr;
  return points;
}

/// A view of the normals of a cloud whose point type has them.
template <typename PointT>
Points normalsOf(const pcl::PointCloud<PointT>& cloud)
{
  Points normals = pointsOf(cloud);
  normals.data = cloud.empty() ? nullptr : &cloud[0].normal_x;
  return normals;
}

} // namespace pcl_gpu_icp::search
