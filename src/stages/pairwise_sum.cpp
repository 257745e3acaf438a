#include "pairwise_sum.h"

#include "launch.h"

#include <utility>

namespace pcl_gpu_icp::stages {

const opencl::Buffer& PairwiseSum::enqueue(
    opencl::Queue& queue, opencl::Buffer& values, cl_uint stride, std::size_t rows, cl_uint m, std::size_t value_bytes)
{
  queue.reserve(sums_, rows * stride * value_bytes);
  opencl::Buffer* from = &values;
  opencl::Buffer* to = &sums_;
  for (; m > 1; m = (m + 1) / 2) {
    queue.launch(stage_, {file_, "pairwise_sum"}, overPoints(queue.traits(), (m + 1) / 2, rows), *from, stride, m, *to);
    std::swap(from, to);
  }
  return *from;
}

} // namespace pcl_gpu_icp::stages
