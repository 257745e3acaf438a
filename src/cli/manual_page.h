#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace pcl_gpu_icp::cli {

/// All commands and options as man(7) takes them.
/// \param date of the page, YYYY-MM-DD
std::string manualPage(const CLI::App& app, const std::string& date);

} // namespace pcl_gpu_icp::cli
