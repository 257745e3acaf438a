#pragma once

#include "opencl/queue.h"

namespace pcl_gpu_icp::stages {

/// The pairwise reduction of stages 1 and 3: rows of m values become one sum each, a launch per level, every level
/// asking for half the work-items of the one before.
class PairwiseSum {
public:
  /// \param file the stage's kernel file, which includes pairwise_sum.h
  PairwiseSum(const char* stage, const char* file)
  : stage_(stage)
  , file_(file)
  {
  }

  /// Reduces rows of `stride` values, of which the first m count. `values` is overwritten.
  /// \return the buffer whose rows start with the sums: `values` or one of this object's
  const opencl::Buffer& enqueue(opencl::Queue& queue,
                                opencl::Buffer& values,
                                cl_uint stride,
                                std::size_t rows,
                                cl_uint m,
                                std::size_t value_bytes);

private:
  const char* stage_;
  const char* file_;
  opencl::Buffer sums_{"partial sums"};
};

} // namespace pcl_gpu_icp::stages
