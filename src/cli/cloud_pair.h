#pragma once

#include "cli/options.h"
#include "cli/prepared_cloud.h"

#include "report/alignment_report.h"

#include <pcl_gpu_icp/rigid_transform.h>

#include <functional>
#include <memory>
#include <string>

namespace pcl_gpu_icp::cli {

/// Two clouds, and where the alignment of one onto the other starts.
struct CloudPair {
  /// \param file_guess in the coordinates of the files; its rotation need not be exactly orthonormal
  CloudPair(std::shared_ptr<const PreparedCloud> from,
            std::shared_ptr<const PreparedCloud> to,
            const RigidTransform& file_guess);

  std::shared_ptr<const PreparedCloud> source;
  std::shared_ptr<const PreparedCloud> target;
  RigidTransform guess; ///< between the prepared clouds
  Warnings warnings;    ///< of both clouds, and of them as a pair

  /// A transform between the prepared clouds, in the coordinates of the files.
  RigidTransform inFileCoordinates(const RigidTransform& transform) const;
};

/// Gives the prepared cloud of a file.
using ReadPrepared = std::function<std::shared_ptr<const PreparedCloud>(const std::string& path)>;

/// Enters into a report, which has its result, what that result means for the files.
/// \param transform between the prepared clouds
void describe(report::AlignmentReport& report,
              const AlignmentOptions& options,
              const CloudPair& pair,
              const RigidTransform& transform);

/// Reads what the arguments name: the guess, then the source, then the target.
/// \throws Failure (Input, Usage)
CloudPair readPair(const AlignmentOptions& options, const ReadPrepared& prepared);

} // namespace pcl_gpu_icp::cli
