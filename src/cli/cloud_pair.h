#pragma once

#include "cli/cloud.h"
#include "cli/options.h"
#include "cli/prepared_cloud.h"

#include "report/alignment_report.h"

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

/// Enters into a report, which has its result, what that result means for the files.
/// \param transform between the prepared clouds
void describe(report::AlignmentReport& report, const CloudPair& pair, const RigidTransform& transform);

/// \throws Failure (Input, Usage)
CloudPair readPair(const AlignmentOptions& options);

} // namespace pcl_gpu_icp::cli
