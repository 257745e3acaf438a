#pragma once

#include <pcl_gpu_icp/result.h>

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

namespace pcl_gpu_icp::cli {

/// What align and compare have in common. An unset value leaves PCL's default.
struct AlignmentOptions {
  std::string source;
  std::string target;
  std::optional<std::string> guess; ///< a file name or 16 numbers
  std::optional<double> max_distance;
  int iterations = 100;
  std::optional<double> translation_epsilon; ///< a distance
  std::optional<double> rotation_epsilon;    ///< degrees
  std::optional<double> fitness_epsilon;
  std::optional<double> leaf;
  bool anderson = false;
  bool reciprocal = false;
  std::optional<double> trim;
  bool drop_zero_returns = false;
  Metric metric = Metric::Point;
  CorrespondenceSearch search = CorrespondenceSearch::PclKdTree;
  Pipeline pipeline = Pipeline::Fused;
  std::string device;
  unsigned threads = 0;
  std::string json; ///< a file name, or "-" for standard output
  bool force = false;
  bool quiet = false;
};

void addAlignmentOptions(CLI::App& command, AlignmentOptions& options);

/// A finite number above zero, for arguments.
CLI::Validator positiveNumber();

} // namespace pcl_gpu_icp::cli
