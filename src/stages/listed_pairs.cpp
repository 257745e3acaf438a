#include "listed_pairs.h"

#include "kernels/layout.h"
#include "launch.h"

namespace pcl_gpu_icp::stages {

void ListedPairs::enqueue(opencl::Queue& queue,
                          const Pairs& pairs,
                          std::size_t real_bytes,
                          const opencl::Buffer& solution)
{
  const cl_uint blocks = (pairs.count + POINTS_PER_BLOCK - 1) / POINTS_PER_BLOCK;
  queue.reserve(partials_, std::size_t(blocks) * SUMS_PER_BLOCK * real_bytes);
  queue.launch("listed_sums",
               {"listed_pairs.cl", "listed_sums"},
               overBlocks(queue.traits(), blocks),
               pairs.rows,
               pairs.stride,
               pairs.count,
               partials_);
  queue.launch("listed_solve",
               {"listed_pairs.cl", "listed_solve"},
               oneGroup(queue.traits(), SUMS_PER_BLOCK),
               partials_,
               blocks,
               pairs.count,
               pairs.resolution_sq,
               solution);
}

} // namespace pcl_gpu_icp::stages
