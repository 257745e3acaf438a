#include "match.h"

#include "launch.h"

#include <algorithm>

namespace pcl_gpu_icp::stages {

namespace {

/// So that the answers take little memory; more at once would be no faster.
constexpr cl_uint most_queries_at_once = 1 << 14;

cl_uint blocksOf(const SourcePoints& source)
{
  return (source.count + POINTS_PER_MATCH_BLOCK - 1) / POINTS_PER_MATCH_BLOCK;
}

} // namespace

void packLeaves(opencl::Queue& queue, const std::vector<PlacedPoint>& points, TargetPoints& target)
{
  const search::TreeShape shape(points.size());
  queue.upload(target.leaves, shape.leaves * LEAF_WORDS * sizeof(float), [&](void* memory) {
    search::writeLeaves(points, static_cast<float*>(memory));
  });
}

void packTree(opencl::Queue& queue, const search::BoxTree& tree, TargetPoints& target)
{
  const auto copy = [&queue](const std::vector<float>& words, opencl::Buffer& buffer) {
    queue.upload(buffer, words.size() * sizeof(float), [&](void* memory) {
      std::copy(words.begin(), words.end(), static_cast<float*>(memory));
    });
  };
  copy(tree.leaves, target.leaves);
  copy(tree.nodes, target.nodes);
  std::copy(tree.shape.first_node.begin(), tree.shape.first_node.end(), target.first_node.s);
  target.root_level = tree.shape.root_level;
}

void packSource(opencl::Queue& queue, const std::vector<PlacedPoint>& sorted, SourcePoints& source)
{
  const std::size_t stride = paddedStride(sorted.size());
  queue.upload(source.rows, 3 * stride * sizeof(float), [&](void* memory) {
    auto* rows = static_cast<float*>(memory);
    for (int axis = 0; axis < 3; ++axis) {
      float* row = rows + axis * stride;
      for (std::size_t i = 0; i < sorted.size(); ++i)
        row[i] = sorted[i].xyz[axis];
      std::fill(row + sorted.size(), row + stride, 0.0F);
    }
  });
  source.stride = static_cast<cl_uint>(stride);
  source.count = static_cast<cl_uint>(sorted.size());
}

void Match::restart(opencl::Queue& queue, const SourcePoints& source)
{
  tested_ = 0;
  const std::size_t stride = source.stride;
  queue.reserve(searched_at_, 5 * stride * sizeof(cl_float));
  queue.reserve(candidates_, KEPT_CANDIDATES * stride * sizeof(cl_int));
  queue.reserve(matches_, stride * sizeof(cl_int));
}

template <typename... Arguments>
void Match::launch(opencl::Queue& queue,
                   const char* kernel,
                   const SourcePoints& source,
                   const RigidTransform& pose,
                   const Arguments&... arguments)
{
  queue.launch(kernel,
               {"match.cl", kernel},
               overBlocks(queue.traits(), blocksOf(source)),
               source.rows,
               searched_at_,
               candidates_,
               matches_,
               source.stride,
               source.count,
               rowsOf(pose),
               arguments...);
}

void Match::writeIgnorance(opencl::Queue& queue, const SourcePoints& source)
{
  const std::size_t stride = source.stride;
  queue.upload(searched_at_, 5 * stride * sizeof(cl_float), [&](void* memory) {
    std::fill_n(static_cast<cl_float*>(memory), 5 * stride, 0.0F);
  });
  queue.upload(candidates_, KEPT_CANDIDATES * stride * sizeof(cl_int), [&](void* memory) {
    std::fill_n(static_cast<cl_int*>(memory), KEPT_CANDIDATES * stride, -1);
  });
}

void Match::reserveSums(opencl::Queue& queue, const SourcePoints& source, std::size_t real_bytes)
{
  queue.reserve(partials_, std::size_t(blocksOf(source)) * SUMS_PER_BLOCK * real_bytes);
  queue.reserve(tallies_, blocksOf(source) * sizeof(cl_uint2));
}

void Match::searchOnDevice(opencl::Queue& queue,
                           const SourcePoints& source,
                           const TargetPoints& target,
                           const RigidTransform& pose,
                           const SearchEffort& effort,
                           std::size_t real_bytes)
{
  reserveSums(queue, source, real_bytes);
  if (tested_ == 0)
    writeIgnorance(queue, source);
  launch(queue,
         "match",
         source,
         pose,
         target.leaves,
         target.nodes,
         target.first_node,
         target.root_level,
         effort.limit_sq,
         effort.slack,
         effort.kept,
         tested_,
         partials_,
         tallies_);
  tested_ = std::max(tested_, effort.kept);
}

std::size_t Match::searchOnHost(opencl::Queue& queue,
                                const SourcePoints& source,
                                const TargetPoints& target,
                                const RigidTransform& pose,
                                const SearchEffort& effort,
                                const HostSearch& search)
{
  if (tested_ == 0) {
    writeIgnorance(queue, source);
    queue.reserve(queries_, (1 + std::size_t(source.stride)) * sizeof(Query));
    queue.reserve(queried_, source.stride * sizeof(cl_uint));
    queue.upload(queries_, sizeof(Query), [](void* memory) { *static_cast<cl_uint*>(memory) = 0; });
  }
  launch(queue, "certify", source, pose, target.leaves, effort.limit_sq, effort.slack, tested_, queries_, queried_);
  // Their number, and with it as many of them as cost nothing to bring along.
  const std::size_t at_once = queue.traits().mapped_memory ? source.count : std::min<std::size_t>(source.count, 1024);
  cl_uint count = 0;
  std::vector<Query> queries;
  const auto fetch = [&](std::size_t most) {
    queue.download(queries_, (1 + most) * sizeof(Query), [&](const void* memory) {
      count = *static_cast<const cl_uint*>(memory);
      const Query* first = static_cast<const Query*>(memory) + 1;
      queries.assign(first, first + std::min<std::size_t>(count, most));
    });
  };
  fetch(at_once);
  if (count > at_once)
    fetch(count);
  for (cl_uint first = 0; first < count; first += most_queries_at_once) {
    const cl_uint some = std::min(count - first, most_queries_at_once);
    queue.upload(answers_, (KEPT_CANDIDATES + 2) * std::size_t(some) * sizeof(cl_int), [&](void* memory) {
      auto* positions = static_cast<cl_int*>(memory);
      auto* reaches = reinterpret_cast<float*>(positions + KEPT_CANDIDATES * std::size_t(some));
      search(queries.data() + first, some, positions, reaches);
    });
    queue.launch("adopt",
                 {"match.cl", "adopt"},
                 overPoints(queue.traits(), some),
                 searched_at_,
                 candidates_,
                 matches_,
                 source.stride,
                 queries_,
                 queried_,
                 answers_,
                 first,
                 some);
  }
  tested_ = std::max(tested_, effort.kept);
  return count;
}

void Match::sum(opencl::Queue& queue,
                const SourcePoints& source,
                const TargetPoints& target,
                const RigidTransform& pose,
                std::size_t real_bytes)
{
  reserveSums(queue, source, real_bytes);
  launch(queue, "accumulate", source, pose, target.leaves, partials_, tallies_);
}

void Match::solve(opencl::Queue& queue, const SourcePoints& source, float resolution_sq, const opencl::Buffer& summary)
{
  queue.launch("match_solve",
               {"match.cl", "match_solve"},
               oneGroup(queue.traits(), SUMS_PER_BLOCK),
               partials_,
               tallies_,
               blocksOf(source),
               resolution_sq,
               summary);
}

} // namespace pcl_gpu_icp::stages
