#pragma once

#include "report/alignment_report.h"
#include "report/json.h"

#include <pcl_gpu_icp/quality.h>

#include <string>
#include <vector>

namespace pcl_gpu_icp::report {

/// By its quality, what is not determined and what the search for its start found.
Judgement judgementOfPose(const AlignmentReport& report);

/// The same, and wrong where there is no answer for another reason.
Judgement judgementOf(const AlignmentReport& report);

/// Whether its quality is good, by itself.
bool liesWell(const AlignmentReport& report);

/// Whether all that speaks against it is another pose that fits as well.
bool isDoubtedForRivalAlone(const AlignmentReport& report);

/// What to try where the verdict is not good, by the options that were not: a sentence each.
std::vector<std::string> adviceFor(const AlignmentReport& report);

/// The verdict and its reasons, in one line.
std::string judgementText(const Judgement& judgement);

/// A line of the summary.
std::string qualityText(const Quality& quality);

Json qualityJson(const Quality& quality);

} // namespace pcl_gpu_icp::report
