#pragma once

#include "report/alignment_report.h"

#include <string>
#include <utility>
#include <vector>

namespace pcl_gpu_icp::report {

/// In milliseconds, by name.
using Times = std::vector<std::pair<std::string, double>>;

/// Host and device times under one roof, in the order in which the time passes: "total" of the engine is "align", the
/// device's entries carry a prefix.
Times timesOf(const AlignmentReport& report);

/// What that time is a part of; "" for the total.
std::string wholeOf(const std::string& what);

/// The total and what it is made of, in a line.
std::string timesText(const AlignmentReport& report);

/// All of them, each below what it is a part of.
std::string nestedTimesText(const AlignmentReport& report);

} // namespace pcl_gpu_icp::report
