#pragma once

#include "pairs.h"

namespace pcl_gpu_icp::stages {

/// The five stages in two kernels: all sums in one pass over the pairs, then everything else.
class ListedPairs {
public:
  /// Writes the whole solution.
  void enqueue(opencl::Queue& queue, const Pairs& pairs, std::size_t real_bytes, const opencl::Buffer& solution);

private:
  opencl::Buffer partials_{"partial sums"};
};

} // namespace pcl_gpu_icp::stages
