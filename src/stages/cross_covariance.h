#pragma once

#include "pairs.h"
#include "pairwise_sum.h"

#include <pcl_gpu_icp/result.h>

namespace pcl_gpu_icp::stages {

/// Stage 3: H = sum p' q'^T by outer products and pairwise sums.
class CrossCovariance {
public:
  /// n work-items, each for a de-meaned pair, halving until one holds H.
  static StageRequest request(std::size_t pairs);

  /// \param demeaned PAIR_ROWS rows of the pairs' stride, of `real` values
  void enqueue(opencl::Queue& queue,
               const Pairs& pairs,
               const opencl::Buffer& demeaned,
               std::size_t real_bytes,
               const opencl::Buffer& solution);

private:
  opencl::Buffer products_{"outer products"};
  PairwiseSum sum_{"cross_covariance", "cross_covariance.cl"};
};

} // namespace pcl_gpu_icp::stages
