#pragma once

#include "cli/cloud.h"

#include <pcl_gpu_icp/rigid_transform.h>

#include <cstdint>
#include <string>
#include <vector>

namespace pcl_gpu_icp::cli {

/// A file's points on their way into a cloud of several.
struct ColouredPart {
  const Cloud& cloud;
  const std::string& path;
  RigidTransform transform;
  bool without_zero_returns = false;
  std::uint32_t colour = 0; ///< 0xRRGGBB
};

/// One cloud of the finite points of all parts, one part after the other: x, y and z, double where a part has them so,
/// and rgb as PCL packs it.
/// \throws Failure (Output) that names `path`, where they are too many for one cloud
Cloud colouredCloud(const std::vector<ColouredPart>& parts, const std::string& path);

} // namespace pcl_gpu_icp::cli
