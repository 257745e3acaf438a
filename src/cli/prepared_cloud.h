#pragma once

#include "cli/cloud.h"
#include "cli/cloud_scale.h"
#include "cli/options.h"

#include "report/alignment_report.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>

namespace pcl_gpu_icp::cli {

/// The points of a file as the alignment gets them: finite, in float about an origin of the cloud's own.
struct PreparedCloud {
  pcl::PointCloud<pcl::PointXYZ>::Ptr points;
  std::array<double, 3> origin{};   ///< zero for a file whose coordinates are float
  std::array<double, 3> centroid{}; ///< in the coordinates of the file, but for points far from all others
  double extent = 0;                ///< twice the root mean square distance from it
  CloudScale scale;                 ///< before voxels merged any
  report::PointCounts counts;
  Warnings warnings; ///< of reading and preparing the file

  /// Of points spread over a surface of that scale.
  double spacing() const { return scale.extent / std::sqrt(static_cast<double>(points->size())); }
};

/// \throws Failure (Input) where no point is left
PreparedCloud prepare(const Cloud& cloud, const std::string& path, const AlignmentOptions& options);

/// The prepared cloud of a file.
/// \throws Failure (Input)
std::shared_ptr<const PreparedCloud> readPrepared(const std::string& path, const AlignmentOptions& options);

} // namespace pcl_gpu_icp::cli
