#pragma once

#include <pcl_gpu_icp/quality.h>

#include <vector>

namespace pcl_gpu_icp {

/// qualityOf() each of the poses, of which all but the poses themselves is looked at once.
std::vector<Quality> qualitiesOf(const Points& source,
                                 const Points& target,
                                 const RigidTransform& guess,
                                 const std::vector<RigidTransform>& poses,
                                 unsigned threads = 0);

} // namespace pcl_gpu_icp
