#pragma once

#include "cli/commands.h"

#include <memory>

namespace pcl_gpu_icp::cli {

/// Every command and option there is: what is parsed, and what help, manual page and shells tell of.
/// \param chosen becomes what to run when arguments have been parsed; outlives the App
std::unique_ptr<CLI::App> makeCommandLine(Run& chosen);

} // namespace pcl_gpu_icp::cli
