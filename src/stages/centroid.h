#pragma once

#include "pairs.h"
#include "pairwise_sum.h"

#include <pcl_gpu_icp/result.h>

namespace pcl_gpu_icp::stages {

/// Stage 1: the centroids of both clouds, each about its pivot, by pairwise sums.
class Centroid {
public:
  /// n work-items, each for a point and its neighbour, halving until one holds the sum.
  static StageRequest request(std::size_t pairs);

  /// Writes the centroids into the solution.
  void enqueue(opencl::Queue& queue, const Pairs& pairs, std::size_t real_bytes, const opencl::Buffer& solution);

private:
  opencl::Buffer rows_{"widened coordinates"};
  PairwiseSum sum_{"centroid", "centroid.cl"};
};

} // namespace pcl_gpu_icp::stages
