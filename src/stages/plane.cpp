#include "plane.h"

#include "launch.h"

#include <cmath>

namespace pcl_gpu_icp::stages {

void packNormals(opencl::Queue& queue, const std::vector<std::array<float, 3>>& normals, opencl::Buffer& leaves)
{
  std::vector<PlacedPoint> placed;
  placed.reserve(normals.size());
  for (const auto& [x, y, z] : normals)
    if (std::isfinite(x) && std::isfinite(y) && std::isfinite(z))
      placed.push_back({{x, y, z}, 0});
    else
      placed.push_back({{0, 0, 0}, 0});
  const search::TreeShape shape(placed.size());
  queue.upload(leaves, shape.leaves * LEAF_WORDS * sizeof(float), [&](void* memory) {
    search::writeLeaves(placed, static_cast<float*>(memory));
  });
}

void Plane::enqueue(opencl::Queue& queue,
                    const SourcePoints& source,
                    const RigidTransform& pose,
                    const opencl::Buffer& matches,
                    const TargetPoints& target,
                    const opencl::Buffer& normals,
                    const std::array<double, 3>& centre,
                    std::size_t real_bytes,
                    const opencl::Buffer& total)
{
  const cl_uint blocks = (source.count + POINTS_PER_MATCH_BLOCK - 1) / POINTS_PER_MATCH_BLOCK;
  queue.reserve(partials_, std::size_t(blocks) * PLANE_SUMS_ROWS * SUMS_PER_BLOCK * real_bytes);
  cl_float4 about{};
  for (int axis = 0; axis < 3; ++axis)
    about.s[axis] = static_cast<float>(centre[axis]);
  queue.launch("plane_sums",
               {"plane.cl", "plane_sums"},
               overBlocks(queue.traits(), blocks),
               source.rows,
               matches,
               source.stride,
               source.count,
               rowsOf(pose),
               target.leaves,
               normals,
               about,
               blocks,
               partials_);
  queue.launch(
      "plane_total", {"plane.cl", "plane_total"}, oneGroup(queue.traits(), SUMS_PER_BLOCK), partials_, blocks, total);
}

} // namespace pcl_gpu_icp::stages
