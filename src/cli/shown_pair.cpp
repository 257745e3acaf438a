#include "cli/shown_pair.h"

#include <pcl_gpu_icp/search/points_of.h>

namespace pcl_gpu_icp::cli {

std::vector<view::NamedPose> posesOf(const report::AlignmentReport& report, const CloudPair& pair)
{
  std::vector<view::NamedPose> poses{{"before", pair.inFileCoordinates(pair.guess)}, {"after", report.transform}};
  if (report.searched_guess && report.searched_guess->rival)
    poses.push_back({"the other that fits", report.searched_guess->rival->transform});
  return poses;
}

view::PairView shownPair(const CloudPair& pair, const std::vector<view::NamedPose>& poses, std::size_t most_points)
{
  const auto cloud = [](const PreparedCloud& prepared) {
    return view::Cloud{search::pointsOf(*prepared.points), prepared.origin};
  };
  return viewOf(cloud(*pair.source), cloud(*pair.target), poses, most_points);
}

} // namespace pcl_gpu_icp::cli
