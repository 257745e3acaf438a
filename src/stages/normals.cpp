#include "normals.h"

#include "launch.h"

namespace pcl_gpu_icp::stages {

void Normals::enqueue(
    opencl::Queue& queue, const SourcePoints& queries, const TargetPoints& target, cl_uint k, float resolution_sq)
{
  queue.reserve(normals_, 3 * std::size_t(queries.stride) * sizeof(float));
  const std::size_t blocks = (queries.count + POINTS_PER_MATCH_BLOCK - 1) / POINTS_PER_MATCH_BLOCK;
  const bool chunked = queue.traits().shape == opencl::Shape::Chunked;
  queue.launch("normals",
               {"normals.cl", "normals"},
               chunked ? overBlocks(queue.traits(), blocks) : overPoints(queue.traits(), queries.count),
               queries.rows,
               queries.stride,
               queries.count,
               target.leaves,
               target.nodes,
               target.first_node,
               target.root_level,
               k,
               resolution_sq,
               normals_);
}

} // namespace pcl_gpu_icp::stages
