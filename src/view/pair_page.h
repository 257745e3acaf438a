#pragma once

#include "report/alignment_report.h"
#include "report/comparison_report.h"
#include "view/page.h"
#include "view/pair_view.h"

#include <string>
#include <vector>

namespace pcl_gpu_icp::view {

/// An alignment as a page.
/// \param errors the root mean square distances of the pairs, by iteration
std::string alignmentPage(const report::AlignmentReport& report,
                          const PairView& view,
                          const std::vector<double>& errors,
                          const Repetition& repetition);

/// A comparison as a page.
/// \param ours the library's run
/// \param view where the source lay, where the library put it and, where it has an answer, stock PCL
std::string comparisonPage(const report::ComparisonReport& report,
                           const report::AlignmentReport& ours,
                           const PairView& view,
                           const std::vector<double>& errors,
                           const Repetition& repetition);

} // namespace pcl_gpu_icp::view
