// What a user of the installed package writes: lists the devices and aligns a cloud with itself moved a little.
#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/version.h>

#include <pcl/common/transforms.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cmath>
#include <iostream>

#if !PCL_GPU_ICP_VERSION_COMPARE(>=, 0, 1, 0) || PCL_GPU_ICP_VERSION_COMPARE(<, 0, 1, 0)
#error the version is compared wrongly
#endif

int main()
{
  std::cout << "pcl_gpu_icp " << PCL_GPU_ICP_VERSION << '\n';
  for (const auto& device : pcl_gpu_icp::Device::list())
    std::cout << device.info().name << '\n';

  auto target = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (int x = 0; x < 40; ++x)
    for (int y = 0; y < 40; ++y)
      target->emplace_back(0.1f * x, 0.1f * y, std::sin(0.2f * x) * std::cos(0.3f * y));
  const Eigen::Affine3f moved =
      Eigen::Translation3f(0.02f, -0.01f, 0.03f) * Eigen::AngleAxisf(0.01f, Eigen::Vector3f::UnitZ());
  auto source = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  pcl::transformPointCloud(*target, *source, moved);

  pcl_gpu_icp::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
  icp.setInputSource(source);
  icp.setInputTarget(target);
  icp.setMaximumIterations(50);
  icp.setTransformationEpsilon(1e-12);
  pcl::PointCloud<pcl::PointXYZ> aligned;
  icp.align(aligned);

  const float error = (icp.getFinalTransformation() * moved.matrix() - Eigen::Matrix4f::Identity()).norm();
  std::cout << "converged " << icp.hasConverged() << ", " << error << " from the truth, on "
            << icp.getResult().device.name << '\n';
  return icp.hasConverged() && error < 1e-3f ? 0 : 1;
}
