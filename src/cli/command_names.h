#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace pcl_gpu_icp::cli {

std::vector<std::string> commandsOf(const CLI::App& app);

/// With their dashes, short ones first.
std::vector<std::string> namesOf(const CLI::Option& option);

/// Those of all its options.
std::vector<std::string> optionsOf(const CLI::App& command);

} // namespace pcl_gpu_icp::cli
