#include "gather.h"

#include "kernels/layout.h"
#include "launch.h"

namespace pcl_gpu_icp::stages {

void Gather::enqueue(opencl::Queue& queue,
                     const Cloud& source,
                     const Cloud& target,
                     const Correspondence* correspondences,
                     std::size_t count,
                     const RigidTransform& pose,
                     Pairs& pairs)
{
  pairs.count = static_cast<cl_uint>(count);
  pairs.stride = paddedStride(count);
  queue.reserve(pairs.rows, std::size_t(PAIR_ROWS) * pairs.stride * sizeof(float));
  queue.upload(matches_, count * sizeof(cl_int2), [&](void* memory) {
    auto* matches = static_cast<cl_int*>(memory);
    for (std::size_t k = 0; k < count; ++k) {
      matches[2 * k] = correspondences[k].source;
      matches[2 * k + 1] = correspondences[k].target;
    }
  });
  queue.launch("gather",
               {"gather.cl", "gather"},
               overPoints(queue.traits(), pairs.stride),
               source.rows,
               source.stride,
               target.rows,
               target.stride,
               matches_,
               pairs.count,
               rowsOf(pose),
               pairs.rows,
               pairs.stride);
}

} // namespace pcl_gpu_icp::stages
