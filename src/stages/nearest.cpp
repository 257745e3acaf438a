#include "nearest.h"

#include "launch.h"

namespace pcl_gpu_icp::stages {

void Nearest::enqueue(opencl::Queue& queue, const SourcePoints& queries, const TargetPoints& target, cl_uint k)
{
  const std::size_t entries = std::size_t(k) * queries.stride;
  queue.reserve(positions_, entries * sizeof(cl_int));
  queue.reserve(squared_distances_, entries * sizeof(float));
  const std::size_t blocks = (queries.count + POINTS_PER_MATCH_BLOCK - 1) / POINTS_PER_MATCH_BLOCK;
  const bool chunked = queue.traits().shape == opencl::Shape::Chunked;
  queue.launch("nearest",
               {"nearest.cl", "nearest"},
               chunked ? overBlocks(queue.traits(), blocks) : overPoints(queue.traits(), queries.count),
               queries.rows,
               queries.stride,
               queries.count,
               target.leaves,
               target.nodes,
               target.first_node,
               target.root_level,
               k,
               positions_,
               squared_distances_);
}

} // namespace pcl_gpu_icp::stages
