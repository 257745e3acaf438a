#pragma once

#include "pairs.h"

#include <pcl_gpu_icp/result.h>

namespace pcl_gpu_icp::stages {

/// Stage 2: every point less its cloud's centroid.
class Demean {
public:
  /// n work-items, each for a point and its centroid.
  static StageRequest request(std::size_t pairs);

  /// Reads the centroids from the solution.
  void enqueue(opencl::Queue& queue, const Pairs& pairs, std::size_t real_bytes, const opencl::Buffer& solution);

  /// De-meaned points: PAIR_ROWS rows of the pairs' stride, of `real` values.
  const opencl::Buffer& demeaned() const { return demeaned_; }

private:
  opencl::Buffer demeaned_{"de-meaned points"};
};

} // namespace pcl_gpu_icp::stages
