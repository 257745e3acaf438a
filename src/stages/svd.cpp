#include "svd.h"

#include "launch.h"

namespace pcl_gpu_icp::stages {

StageRequest Svd::request() { return {"svd", {27, 9, 1}}; }

void Svd::enqueue(opencl::Queue& queue, const Pairs& pairs, const opencl::Buffer& solution)
{
  queue.launch("svd", {"svd.cl", "svd"}, oneGroup(queue.traits(), 27), pairs.count, pairs.resolution_sq, solution);
}

} // namespace pcl_gpu_icp::stages
