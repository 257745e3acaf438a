// Only the rigid estimation on the device, inside a pipeline of PCL's own classes.
//   estimator_in_pipeline [SOURCE.pcd TARGET.pcd]
#include "cloud_pair.h"

#include <pcl_gpu_icp/transformation_estimation_svd.h>

#include <pcl/registration/correspondence_rejection_trimmed.h>
#include <pcl/registration/icp.h>

#include <iostream>

int main(int argc, char** argv)
{
  const CloudPair pair = cloudPair(argc, argv);

  pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
  using Estimation = pcl_gpu_icp::TransformationEstimationSVD<pcl::PointXYZ, pcl::PointXYZ>;
  const Estimation::Ptr estimation(new Estimation);
  icp.setTransformationEstimation(estimation);

  const pcl::registration::CorrespondenceRejectorTrimmed::Ptr trimmed(
      new pcl::registration::CorrespondenceRejectorTrimmed);
  trimmed->setOverlapRatio(0.9f);
  icp.addCorrespondenceRejector(trimmed);

  icp.setInputSource(pair.source);
  icp.setInputTarget(pair.target);
  icp.setMaximumIterations(50);
  icp.setTransformationEpsilon(1e-10);
  Cloud aligned;
  icp.align(aligned);

  const pcl_gpu_icp::Estimate last = estimation->getEstimate();
  std::cout << "converged " << icp.hasConverged() << " on " << estimation->getDevice().info().name << '\n'
            << icp.getFinalTransformation() << '\n'
            << "last iteration: " << last.pairs << " pairs, singular values " << last.stages.S[0] << ' '
            << last.stages.S[1] << ' ' << last.stages.S[2] << '\n';
  return icp.hasConverged() ? 0 : 1;
}
