#pragma once

#include "view/page.h"

#include <string>
#include <vector>

namespace pcl_gpu_icp::cli {

/// What started this process.
std::vector<std::string> argumentsOfThisRun();

/// The same, as a shell takes it, also where arguments are no UTF-8 or have line feeds in them.
view::Repetition thisRun();

} // namespace pcl_gpu_icp::cli
