#pragma once

#include "report/batch_report.h"
#include "view/batch_gallery.h"
#include "view/page.h"

#include <pcl_gpu_icp/rigid_transform.h>

#include <string>
#include <string_view>
#include <vector>

namespace pcl_gpu_icp::view {

/// A batch as a page.
/// \param results lines of the results file, of any run
/// \param trajectory the poses of a sequence's scans; empty where there is none
std::string batchPage(const report::BatchReport& report,
                      std::string_view results,
                      const BatchGallery& gallery,
                      const std::vector<RigidTransform>& trajectory,
                      const Repetition& repetition);

} // namespace pcl_gpu_icp::view
