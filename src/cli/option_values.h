#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace pcl_gpu_icp::cli {

/// What an option takes, as its type in the help says: FILE|auto are files and a word.
struct OptionValues {
  bool any = false; ///< not a flag
  bool files = false;
  bool directories = false;
  std::vector<std::string> words;
};

OptionValues valuesOf(const CLI::Option& option);

} // namespace pcl_gpu_icp::cli
