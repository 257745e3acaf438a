// Aligns, asks whether to believe the answer and, where not, searches for where to start.
//   judge_answer [SOURCE TARGET]
#include "cloud_pair.h"

#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/matrix.h>
#include <pcl_gpu_icp/pose_search.h>
#include <pcl_gpu_icp/search/points_of.h>

#include <iostream>

using Icp = pcl_gpu_icp::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ>;

/// Whether the answer from that guess is good.
bool alignFrom(Icp& icp, const Icp::Matrix4& guess)
{
  Cloud aligned;
  icp.align(aligned, guess);
  if (!icp.getResult().quality) {
    std::cout << icp.getResult().message << '\n';
    return false;
  }
  const pcl_gpu_icp::Judgement judgement = pcl_gpu_icp::judge(*icp.getResult().quality);
  std::cout << toString(judgement.verdict) << '\n';
  for (const std::string& reason : judgement.reasons)
    std::cout << "  " << reason << '\n';
  return judgement.verdict == pcl_gpu_icp::Verdict::Good;
}

int main(int argc, char** argv)
{
  const CloudPair pair = cloudPair(argc, argv);
  Icp icp;
  icp.setCorrespondenceSearch(pcl_gpu_icp::CorrespondenceSearch::DeviceKdTree);
  icp.setMaximumIterations(100);
  icp.setInputSource(pair.source);
  icp.setInputTarget(pair.target);
  // Half a turn off, as where nothing is known.
  const Eigen::Affine3f guess(Eigen::AngleAxisf(3.14F, Eigen::Vector3f::UnitX()));
  if (alignFrom(icp, guess.matrix()))
    return 0;
  const auto found =
      pcl_gpu_icp::PoseSearch(pcl_gpu_icp::Device::select())
          .search(pcl_gpu_icp::search::pointsOf(*pair.source), pcl_gpu_icp::search::pointsOf(*pair.target));
  return !found.poses.empty() && alignFrom(icp, pcl_gpu_icp::toMatrix(found.poses[0].transform)) ? 0 : 1;
}
