#pragma once

#include "stages/match.h"

#include <pcl_gpu_icp/matcher.h>

#include <array>
#include <memory>
#include <vector>

namespace pcl_gpu_icp {

/// A cloud as the device has it.
struct PlacedCloud {
  std::vector<PlacedPoint> points; ///< in the device's order
  std::array<double, 3> pivot{};
  float rounding = 0; ///< half a unit in the last place of the largest coordinate, but for points far from all others

  void place(const Points& cloud, unsigned threads);
  void place(const search::NearestIndex& index);
};

struct MatchTarget {
  PlacedCloud cloud;
  stages::TargetPoints on_device;
  std::shared_ptr<const search::NearestIndex> index; ///< null: the device searches
  float spacing = 0;                                 ///< between the points
  std::size_t device_bytes = 0;

  /// Answers a device's queries from the index, see stages::Match.
  void searchIndex(const stages::SearchEffort& effort,
                   unsigned threads,
                   const stages::Query* queries,
                   std::size_t count,
                   cl_int* positions,
                   float* reaches) const;
};

} // namespace pcl_gpu_icp
