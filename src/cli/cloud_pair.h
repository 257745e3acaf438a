#pragma once

#include "cli/cloud.h"
#include "cli/options.h"
#include "cli/prepared_cloud.h"

#include <pcl_gpu_icp/rigid_transform.h>

namespace pcl_gpu_icp::cli {

/// The two clouds and the guess that the arguments name.
struct CloudPair {
  Cloud source_file;
  PreparedCloud source;
  PreparedCloud target;
  RigidTransform guess; ///< between the prepared clouds

  /// A transform between the prepared clouds, in the coordinates of the files.
  RigidTransform inFileCoordinates(const RigidTransform& transform) const;
};

/// \throws Failure (Input, Usage)
CloudPair readPair(const AlignmentOptions& options);

} // namespace pcl_gpu_icp::cli
