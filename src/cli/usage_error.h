#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace pcl_gpu_icp::cli {

/// What is wrong with arguments that could not be parsed, in one line.
std::string usageErrorText(const CLI::App& app, const CLI::ParseError& error);

} // namespace pcl_gpu_icp::cli
