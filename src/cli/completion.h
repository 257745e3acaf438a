#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace pcl_gpu_icp::cli {

/// Scripts that complete commands, options, files and the words that options take.
std::string bashCompletion(const CLI::App& app);
std::string zshCompletion(const CLI::App& app);

} // namespace pcl_gpu_icp::cli
