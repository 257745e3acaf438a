#pragma once

#include "cli/failure.h"

#include <CLI/CLI.hpp>

#include <functional>

namespace pcl_gpu_icp::cli {

/// Runs one subcommand whose arguments have been parsed. Throws Failure, or DeviceError.
using Run = std::function<ExitCode()>;

Run addAlign(CLI::App& command);
Run addBatch(CLI::App& command);
Run addCompare(CLI::App& command);
Run addDevices(CLI::App& command);

} // namespace pcl_gpu_icp::cli
