#include "rigid_transform.h"

#include "launch.h"

namespace pcl_gpu_icp::stages {

StageRequest RotationTranslation::request() { return {"rigid_transform", {27, 9, 3}}; }

void RotationTranslation::enqueue(opencl::Queue& queue, const opencl::Buffer& solution)
{
  queue.launch("rigid_transform", {"rigid_transform.cl", "rigid_transform"}, oneGroup(queue.traits(), 27), solution);
}

} // namespace pcl_gpu_icp::stages
