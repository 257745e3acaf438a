// PCL's ICP and this package's, side by side: the class's name is all that differs.
//   replace_stock_icp [SOURCE.pcd TARGET.pcd]
#include "cloud_pair.h"

#include <pcl_gpu_icp/icp.h>

#include <iostream>

template <typename Icp>
bool align(const char* name, const CloudPair& pair)
{
  Icp icp;
  icp.setInputSource(pair.source);
  icp.setInputTarget(pair.target);
  icp.setMaxCorrespondenceDistance(0.5);
  icp.setMaximumIterations(50);
  icp.setTransformationEpsilon(1e-10);
  Cloud aligned;
  icp.align(aligned);
  std::cout << name << ": converged " << icp.hasConverged() << ", fitness " << icp.getFitnessScore() << '\n'
            << icp.getFinalTransformation() << '\n';
  return icp.hasConverged();
}

int main(int argc, char** argv)
{
  const CloudPair pair = cloudPair(argc, argv);
  const bool before = align<pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ>>("pcl", pair);
  const bool after = align<pcl_gpu_icp::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ>>("pcl_gpu_icp", pair);
  return before && after ? 0 : 1;
}
