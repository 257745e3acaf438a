#pragma once

#include "report/difference.h"

#include <pcl_gpu_icp/result.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pcl_gpu_icp::report {

/// One implementation's run.
struct Run {
  bool converged = false;
  Reason reason = Reason::NotRun;
  int iterations = 0;
  double time_ms = 0;                  ///< align(), tree and device start included
  std::optional<double> rmse;          ///< over source points with a target point within the maximum distance
  std::optional<double> fitness_score; ///< PCL's: mean squared distance over all source points
  RigidTransform transform;            ///< source to target, in the coordinates of the files
};

struct ComparisonReport {
  std::vector<std::string> arguments; ///< of the command, and before them its name
  std::string source;                 ///< file names as given
  std::string target;
  std::size_t source_points = 0; ///< used
  std::size_t target_points = 0;
  std::optional<Run> stock;
  std::string stock_failure; ///< why stock has no answer, where it has none
  Run plugin;
  Judgement judgement;        ///< of that
  double plugin_start_ms = 0; ///< device and kernels, part of the plugin's time
  DeviceInfo device;
  Pipeline pipeline = Pipeline::Fused;
  Metric metric = Metric::Point;
  std::array<double, 3> centroid{}; ///< of the source
  Difference tolerance;

  std::optional<Difference> difference() const; ///< nothing where stock has no answer
  bool agree() const;
};

/// What became of stock PCL.
std::string stockText(const ComparisonReport& report);

std::string toText(const ComparisonReport& report);
std::string toJson(const ComparisonReport& report);

} // namespace pcl_gpu_icp::report
