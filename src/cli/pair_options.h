#pragma once

#include "cli/options.h"

#include <CLI/CLI.hpp>

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_gpu_icp::cli {

/// Options of addPairOptions() as text, by their names without dashes. A flag is "true" or "false"; of numbers that
/// are equal the text is equal.
using OptionTexts = std::map<std::string, std::string>;

/// Reads options of a pair that stand elsewhere than on the command line.
class PairOptions {
public:
  PairOptions();
  PairOptions(const PairOptions&) = delete;
  PairOptions& operator=(const PairOptions&) = delete;

  bool has(const std::string& name) const;
  std::vector<std::string> names() const;

  /// Those that a command got.
  OptionTexts givenTo(const CLI::App& command) const;

  /// What an option's text becomes in OptionTexts.
  /// \throws std::invalid_argument that says what is wrong with it
  std::string checked(const std::string& name, const std::string& text);

  /// \param texts which have been checked
  AlignmentOptions parse(const OptionTexts& texts);

private:
  CLI::App app_;
  AlignmentOptions options_;
};

} // namespace pcl_gpu_icp::cli
