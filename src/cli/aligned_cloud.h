#pragma once

#include "cli/cloud.h"

#include <pcl_gpu_icp/rigid_transform.h>

namespace pcl_gpu_icp::cli {

/// Moves the points of a cloud, its normals and the pose of its sensor, each in its own type and computed in
/// double. Every other field and element stays as it is.
/// \param keep_zero_returns leaves points at exactly (0, 0, 0), which are no measurements, where they are
void transform(Cloud& cloud, const RigidTransform& transform, bool keep_zero_returns);

} // namespace pcl_gpu_icp::cli
