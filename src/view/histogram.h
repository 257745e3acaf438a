#pragma once

#include "view/pair_view.h"

#include <cstddef>
#include <vector>

namespace pcl_gpu_icp::view {

/// How many of the source points shown are how far from the target, at each pose.
struct Histogram {
  std::vector<double> edges; ///< of the bins, each above 0 and the same multiple of the one before
  /// By pose, then by bin; what is nearer than the first edge is in the first bin, what is farther than the last in the
  /// last.
  std::vector<std::vector<std::size_t>> counts;
  std::vector<double> medians; ///< of the distances, by pose
};

Histogram histogramOf(const PairView& view);

} // namespace pcl_gpu_icp::view
