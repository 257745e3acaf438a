#include "system.h"

#include "launch.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace pcl_gpu_icp::stages {

void packNormals(opencl::Queue& queue, const std::vector<std::array<float, 3>>& normals, MetricPoints& own)
{
  queue.upload(own.target, normals.size() * NORMAL_WORDS * sizeof(float), [&](void* memory) {
    auto* words = static_cast<float*>(memory);
    for (const auto& [x, y, z] : normals) {
      const bool finite = std::isfinite(x) && std::isfinite(y) && std::isfinite(z);
      for (const float word : {x, y, z, 0.0F})
        *words++ = finite ? word : 0;
    }
  });
}

void packTargetCovariances(opencl::Queue& queue, const std::vector<Covariance>& covariances, MetricPoints& own)
{
  queue.upload(own.target, covariances.size() * COVARIANCE_WORDS * sizeof(float), [&](void* memory) {
    auto* words = static_cast<float*>(memory);
    for (const Covariance& covariance : covariances) {
      std::copy(covariance.begin(), covariance.end(), words);
      std::fill(words + covariance.size(), words + COVARIANCE_WORDS, 0.0F);
      words += COVARIANCE_WORDS;
    }
  });
}

void packSourceCovariances(opencl::Queue& queue,
                           const std::vector<Covariance>& covariances,
                           const SourcePoints& source,
                           MetricPoints& own)
{
  const std::size_t stride = source.stride;
  queue.upload(own.source, COVARIANCE_ROWS * stride * sizeof(float), [&](void* memory) {
    auto* rows = static_cast<float*>(memory);
    std::fill(rows, rows + COVARIANCE_ROWS * stride, 0.0F);
    for (std::size_t i = 0; i < covariances.size(); ++i)
      for (std::size_t row = 0; row < COVARIANCE_ROWS; ++row)
        rows[i + row * stride] = covariances[i][row];
  });
}

void System::enqueue(opencl::Queue& queue,
                     Metric metric,
                     const SourcePoints& source,
                     const RigidTransform& pose,
                     const RigidTransform& turn,
                     const opencl::Buffer& matches,
                     const TargetPoints& target,
                     const MetricPoints& own,
                     const std::array<double, 3>& centre,
                     std::size_t real_bytes,
                     const opencl::Buffer& total)
{
  const cl_uint blocks = (source.count + POINTS_PER_MATCH_BLOCK - 1) / POINTS_PER_MATCH_BLOCK;
  queue.reserve(partials_, std::size_t(blocks) * SYSTEM_SUMS_ROWS * SUMS_PER_BLOCK * real_bytes);
  cl_float4 about{};
  for (int axis = 0; axis < 3; ++axis)
    about.s[axis] = static_cast<float>(centre[axis]);
  const bool planes = metric == Metric::Plane;
  const char* const file = planes ? "plane_factor.cl" : "generalized_factor.cl";
  queue.launch(planes ? "plane_sums" : "gicp_sums",
               {file, "system_sums"},
               overBlocks(queue.traits(), blocks),
               source.rows,
               matches,
               source.stride,
               source.count,
               rowsOf(pose),
               target.leaves,
               own.target,
               planes ? own.target : own.source,
               rowsOf(turn),
               about,
               blocks,
               partials_);
  queue.launch(planes ? "plane_total" : "gicp_total",
               {file, "system_total"},
               oneGroup(queue.traits(), SUMS_PER_BLOCK),
               partials_,
               blocks,
               total);
}

} // namespace pcl_gpu_icp::stages
