#include "demean.h"

#include "kernels/layout.h"
#include "launch.h"

namespace pcl_gpu_icp::stages {

StageRequest Demean::request(std::size_t pairs) { return {"demean", {pairs}}; }

void Demean::enqueue(opencl::Queue& queue, const Pairs& pairs, std::size_t real_bytes, const opencl::Buffer& solution)
{
  queue.reserve(demeaned_, std::size_t(PAIR_ROWS) * pairs.stride * real_bytes);
  queue.launch("demean",
               {"demean.cl", "demean"},
               overPoints(queue.traits(), pairs.stride, PAIR_ROWS),
               pairs.rows,
               pairs.stride,
               pairs.count,
               solution,
               demeaned_);
}

} // namespace pcl_gpu_icp::stages
