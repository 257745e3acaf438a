// The templates that much of this build uses, compiled once: included before anything else by targets that
// pcl_gpu_icp_use_instances() names. Users of the library instantiate them themselves.
#pragma once

#include <pcl_gpu_icp/gicp.h>
#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/icp_with_normals.h>

#include <pcl/point_types.h>

#define PCL_GPU_ICP_POINT_INSTANCES(TEMPLATE, Point, Scalar)                                                           \
  TEMPLATE pcl::Registration<Point, Point, Scalar>;                                                                    \
  TEMPLATE pcl::IterativeClosestPoint<Point, Point, Scalar>;                                                           \
  TEMPLATE pcl::registration::CorrespondenceEstimation<Point, Point, Scalar>;                                          \
  TEMPLATE pcl::registration::TransformationEstimationSVD<Point, Point, Scalar>;                                       \
  TEMPLATE pcl_gpu_icp::DeviceTransformationEstimation<Point, Point, Scalar, pcl_gpu_icp::RigidEstimator>;             \
  TEMPLATE pcl_gpu_icp::DeviceTransformationEstimation<Point, Point, Scalar, pcl_gpu_icp::PlaneEstimator>;             \
  TEMPLATE pcl_gpu_icp::TransformationEstimationSVD<Point, Point, Scalar>;                                             \
  TEMPLATE pcl_gpu_icp::TransformationEstimationPointToPlaneLLS<Point, Point, Scalar>;                                 \
  TEMPLATE pcl_gpu_icp::DeviceIcp<pcl::IterativeClosestPoint<Point, Point, Scalar>>;                                   \
  TEMPLATE pcl_gpu_icp::IterativeClosestPoint<Point, Point, Scalar>;

#define PCL_GPU_ICP_NORMAL_INSTANCES(TEMPLATE, Point, Scalar)                                                          \
  TEMPLATE pcl::registration::TransformationEstimationPointToPlaneLLS<Point, Point, Scalar>;                           \
  TEMPLATE pcl::registration::TransformationEstimationSymmetricPointToPlaneLLS<Point, Point, Scalar>;                  \
  TEMPLATE pcl::IterativeClosestPointWithNormals<Point, Point, Scalar>;                                                \
  TEMPLATE pcl_gpu_icp::DeviceIcp<pcl::IterativeClosestPointWithNormals<Point, Point, Scalar>>;

#define PCL_GPU_ICP_GENERALIZED_INSTANCES(TEMPLATE, Point)                                                             \
  TEMPLATE pcl::GeneralizedIterativeClosestPoint<Point, Point>;                                                        \
  TEMPLATE pcl_gpu_icp::DeviceIcp<pcl::GeneralizedIterativeClosestPoint<Point, Point>>;                                \
  TEMPLATE pcl_gpu_icp::GeneralizedIterativeClosestPoint<Point, Point>;

#define PCL_GPU_ICP_DECLARED extern template class
PCL_GPU_ICP_POINT_INSTANCES(PCL_GPU_ICP_DECLARED, pcl::PointXYZ, float)
PCL_GPU_ICP_POINT_INSTANCES(PCL_GPU_ICP_DECLARED, pcl::PointXYZ, double)
PCL_GPU_ICP_POINT_INSTANCES(PCL_GPU_ICP_DECLARED, pcl::PointNormal, float)
PCL_GPU_ICP_NORMAL_INSTANCES(PCL_GPU_ICP_DECLARED, pcl::PointNormal, float)
PCL_GPU_ICP_GENERALIZED_INSTANCES(PCL_GPU_ICP_DECLARED, pcl::PointXYZ)
