#include <pcl_gpu_icp/normal_estimator.h>

#include "normal_estimator_internals.h"
#include "search/box_tree_query.h"
#include "stages/launch.h"
#include "stages/normals.h"
#include "stages/pack.h"

#include <pcl_gpu_icp/error.h>
#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace pcl_gpu_icp {

namespace {

/// So that the neighbours take little memory; more at once would be no faster.
constexpr std::size_t queries_at_once = 1 << 15;

static_assert(NormalEstimator::most_neighbours == NEAREST_MOST, "the kernel's own limit");

} // namespace

void requireNormals(const Points& normals, const char* whose)
{
  for (std::size_t i = 0; i < normals.count; ++i) {
    const float* normal = normals[i];
    const float squared_length = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
    if (std::isfinite(squared_length) && squared_length > 0)
      return;
  }
  throw InvalidArgument(std::string("no point of the ") + whose +
                        " has a normal: all are zero or not finite; pcl::NormalEstimation computes them");
}

struct NormalEstimator::Implementation {
  Implementation(const Device& device, const opencl::Traits& traits, Precision wanted_precision)
  : precision(stages::available(wanted_precision, traits))
  , queue(device, traits, stages::buildOptions(traits, precision))
  {
  }

  Precision precision;
  opencl::Queue queue;
  stages::TargetPoints target;
  stages::SourcePoints queries;
  stages::Normals stage;
};

NormalEstimator::NormalEstimator(const Device& device, Precision precision)
: NormalEstimator(makeNormalEstimator(device, opencl::Traits::of(device.info()), precision))
{
}
NormalEstimator::NormalEstimator(std::unique_ptr<Implementation> implementation)
: implementation_(std::move(implementation))
{
}
NormalEstimator::~NormalEstimator() = default;
NormalEstimator::NormalEstimator(NormalEstimator&&) noexcept = default;
NormalEstimator& NormalEstimator::operator=(NormalEstimator&&) noexcept = default;

NormalEstimator makeNormalEstimator(const Device& device, const opencl::Traits& traits, Precision precision)
{
  return NormalEstimator(std::make_unique<NormalEstimator::Implementation>(device, traits, precision));
}

void NormalEstimator::setShare(std::shared_ptr<DeviceShare> share)
{
  implementation_->queue.setShare(std::move(share));
}

const DeviceInfo& NormalEstimator::device() const { return implementation_->queue.info(); }
Precision NormalEstimator::precision() const { return implementation_->precision; }

NormalEstimator::Normals NormalEstimator::estimate(const Points& points, unsigned neighbours)
{
  if (neighbours < 3 || neighbours > most_neighbours)
    throw InvalidArgument("a normal is estimated from 3 to " + std::to_string(most_neighbours) + " points, not from " +
                          std::to_string(neighbours));
  Implementation& self = *implementation_;
  constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
  Normals normals(points.count, {not_a_number, not_a_number, not_a_number});

  const unsigned threads = effectiveThreads(0);
  const auto pivot = search::pivotOf(points);
  std::vector<PlacedPoint> all = search::finitePoints(points, pivot, threads);
  // The position of a finite point becomes its place among all points.
  std::size_t next = 0;
  for (std::size_t i = 0; i < points.count; ++i)
    if (next < all.size() && all[next].position == static_cast<std::int32_t>(points.position(i)))
      all[next++].position = static_cast<std::int32_t>(i);
  std::vector<PlacedPoint> distinct = all;
  search::dropCoincident(distinct);
  search::sortIntoLeaves(distinct, threads);
  if (distinct.size() == all.size())
    all = distinct;
  else
    search::sortIntoLeaves(all, threads);
  stages::packTree(self.queue, search::BoxTree(distinct, threads), self.target);

  const auto k = static_cast<cl_uint>(neighbours);
  const float rounding = stages::placementOf(points).rounding;
  for (std::size_t first = 0; first < all.size(); first += queries_at_once) {
    const std::vector<PlacedPoint> some(all.begin() + first,
                                        all.begin() + std::min(first + queries_at_once, all.size()));
    stages::packSource(self.queue, some, self.queries);
    // A coordinate that is off by up to half a unit varies by a third of its square.
    self.stage.enqueue(self.queue, self.queries, self.target, k, rounding * rounding / 3);
    const std::size_t stride = self.queries.stride;
    self.queue.download(self.stage.normals(), 3 * stride * sizeof(float), [&](const void* memory) {
      const auto* rows = static_cast<const float*>(memory);
      for (std::size_t i = 0; i < some.size(); ++i)
        normals[some[i].position] = {rows[i], rows[i + stride], rows[i + 2 * stride]};
    });
  }
  return normals;
}

StageTimes NormalEstimator::takeTimes()
{
  StageTimes times;
  for (const auto& [what, entry] : implementation_->queue.takeProfile().entries)
    times[what] = {entry.milliseconds, entry.count};
  return times;
}

} // namespace pcl_gpu_icp
