#pragma once

#include <pcl/common/transforms.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cmath>
#include <stdexcept>

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

struct CloudPair {
  Cloud::Ptr source{new Cloud};
  Cloud::Ptr target{new Cloud};
};

/// The two .pcd files named on the command line, SOURCE and TARGET, or a generated surface and a moved copy of it.
inline CloudPair cloudPair(int argc, char** argv)
{
  CloudPair pair;
  if (argc == 3) {
    if (pcl::io::loadPCDFile(argv[1], *pair.source) < 0 || pcl::io::loadPCDFile(argv[2], *pair.target) < 0)
      throw std::runtime_error("cannot read the clouds");
    return pair;
  }
  for (int x = 0; x < 60; ++x)
    for (int y = 0; y < 60; ++y)
      pair.target->emplace_back(0.1f * x, 0.1f * y, std::sin(0.2f * x) * std::cos(0.3f * y));
  const Eigen::Affine3f moved =
      Eigen::Translation3f(0.04f, -0.03f, 0.05f) * Eigen::AngleAxisf(0.02f, Eigen::Vector3f::UnitZ());
  pcl::transformPointCloud(*pair.target, *pair.source, moved);
  return pair;
}
