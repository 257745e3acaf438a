#include "system.h"

#include "launch.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace pcl_gpu_icp::stages {

namespace {

struct Factor {
  const char* file;
  const char* sums; ///< what the launches are called
  const char* total;
};

Factor factorOf(Metric metric)
{
  switch (metric) {
  case Metric::Point:
    return {"point_factor.cl", "point_sums", "point_total"};
  case Metric::Plane:
    return {"plane_factor.cl", "plane_sums", "plane_total"};
  case Metric::Symmetric:
    return {"symmetric_factor.cl", "symmetric_sums", "symmetric_total"};
  default:
    return {"generalized_factor.cl", "gicp_sums", "gicp_total"};
  }
}

cl_uint lossNumber(LossFunction function)
{
  switch (function) {
  case LossFunction::None:
    return LOSS_NONE;
  case LossFunction::Huber:
    return LOSS_HUBER;
  case LossFunction::Cauchy:
    return LOSS_CAUCHY;
  case LossFunction::GemanMcClure:
    return LOSS_GEMAN_MCCLURE;
  case LossFunction::Tukey:
    return LOSS_TUKEY;
  default:
    return LOSS_WELSCH;
  }
}

/// Zero where it is not finite.
Normal usable(const Normal& normal)
{
  const bool finite = std::all_of(normal.begin(), normal.end(), [](float entry) { return std::isfinite(entry); });
  return finite ? normal : Normal{};
}

/// As many rows as a value has entries.
template <std::size_t rows>
void packSourceRows(opencl::Queue& queue,
                    const std::vector<std::array<float, rows>>& values,
                    const SourcePoints& source,
                    opencl::Buffer& buffer)
{
  const std::size_t stride = source.stride;
  queue.upload(buffer, rows * stride * sizeof(float), [&](void* memory) {
    auto* entries = static_cast<float*>(memory);
    std::fill(entries, entries + rows * stride, 0.0F);
    for (std::size_t i = 0; i < values.size(); ++i)
      for (std::size_t row = 0; row < rows; ++row)
        entries[i + row * stride] = values[i][row];
  });
}

} // namespace

void packTargetNormals(opencl::Queue& queue, const std::vector<Normal>& normals, MetricPoints& own)
{
  queue.upload(own.target, normals.size() * NORMAL_WORDS * sizeof(float), [&](void* memory) {
    auto* words = static_cast<float*>(memory);
    for (const Normal& normal : normals) {
      const auto [x, y, z] = usable(normal);
      for (const float word : {x, y, z, 0.0F})
        *words++ = word;
    }
  });
}

void packSourceNormals(opencl::Queue& queue,
                       const std::vector<Normal>& normals,
                       const SourcePoints& source,
                       MetricPoints& own)
{
  std::vector<Normal> usable_normals(normals.size());
  std::transform(normals.begin(), normals.end(), usable_normals.begin(), usable);
  packSourceRows(queue, usable_normals, source, own.source);
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
  packSourceRows(queue, covariances, source, own.source);
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
                     const Loss& loss,
                     bool keeps_residuals,
                     std::size_t real_bytes,
                     const opencl::Buffer& total)
{
  const Factor factor = factorOf(metric);
  const cl_uint blocks = (source.count + POINTS_PER_MATCH_BLOCK - 1) / POINTS_PER_MATCH_BLOCK;
  queue.reserve(partials_, std::size_t(blocks) * SYSTEM_SUMS_ROWS * SUMS_PER_BLOCK * real_bytes);
  cl_float4 about{};
  for (int axis = 0; axis < 3; ++axis)
    about.s[axis] = static_cast<float>(centre[axis]);
  queue.reserve(residuals_, (keeps_residuals ? source.stride : 1) * sizeof(cl_float));
  queue.launch(factor.sums,
               {factor.file, "system_sums"},
               overBlocks(queue.traits(), blocks),
               source.rows,
               matches,
               source.stride,
               source.count,
               rowsOf(pose),
               target.leaves,
               metric == Metric::Point ? target.leaves : own.target,
               knowsBothSurfaces(metric) ? own.source : target.leaves,
               rowsOf(turn),
               about,
               lossNumber(loss.function),
               static_cast<cl_float>(loss.scale),
               cl_uint(keeps_residuals),
               residuals_,
               blocks,
               partials_);
  queue.launch(
      factor.total, {factor.file, "system_total"}, oneGroup(queue.traits(), SUMS_PER_BLOCK), partials_, blocks, total);
}

} // namespace pcl_gpu_icp::stages
