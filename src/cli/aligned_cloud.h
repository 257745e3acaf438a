#pragma once

#include "cli/cloud.h"

#include <pcl_gpu_icp/rigid_transform.h>

namespace pcl_gpu_icp::cli {

/// Moves the points of a cloud and turns their normals, each in its own type and computed in double. Every other field
/// stays as it is, and so does the VIEWPOINT, as in pcl_transform_point_cloud.
/// \param keep_zero_returns leaves points at exactly (0, 0, 0), which are no measurements, where they are
void transform(Cloud& cloud, const RigidTransform& transform, bool keep_zero_returns);

} // namespace pcl_gpu_icp::cli
