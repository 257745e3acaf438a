#include <pcl_gpu_icp/plane_estimator.h>

#include "plane_estimator_internals.h"
#include "search/box_tree.h"
#include "solution.h"
#include "stages/launch.h"
#include "system_increment.h"

#include <pcl_gpu_icp/error.h>

#include <cmath>
#include <numeric>
#include <string>
#include <vector>

namespace pcl_gpu_icp {

namespace {

bool isFinite(const float* xyz) { return std::isfinite(xyz[0]) && std::isfinite(xyz[1]) && std::isfinite(xyz[2]); }

PlacedPoint placed(const float* xyz, const std::array<double, 3>& pivot, std::size_t position)
{
  return {{xyz[0] - static_cast<float>(pivot[0]),
           xyz[1] - static_cast<float>(pivot[1]),
           xyz[2] - static_cast<float>(pivot[2])},
          static_cast<std::int32_t>(position)};
}

} // namespace

struct PlaneEstimator::Implementation {
  Implementation(const Device& device, const opencl::Traits& traits, Precision wanted_precision)
  : precision(stages::available(wanted_precision, traits))
  , queue(device, traits, stages::buildOptions(traits, precision))
  {
  }

  Precision precision;
  opencl::Queue queue;
  stages::TargetPoints target;
  opencl::Buffer matches{"matches"};
  stages::SourcePoints source;
  SystemIncrement increment;
};

PlaneEstimator::PlaneEstimator(const Device& device, Precision precision)
: PlaneEstimator(makePlaneEstimator(device, opencl::Traits::of(device.info()), precision))
{
}
PlaneEstimator::PlaneEstimator(std::unique_ptr<Implementation> implementation)
: implementation_(std::move(implementation))
{
}
PlaneEstimator::~PlaneEstimator() = default;
PlaneEstimator::PlaneEstimator(PlaneEstimator&&) noexcept = default;
PlaneEstimator& PlaneEstimator::operator=(PlaneEstimator&&) noexcept = default;

PlaneEstimator makePlaneEstimator(const Device& device, const opencl::Traits& traits, Precision precision)
{
  return PlaneEstimator(std::make_unique<PlaneEstimator::Implementation>(device, traits, precision));
}

const DeviceInfo& PlaneEstimator::device() const { return implementation_->queue.info(); }
Precision PlaneEstimator::precision() const { return implementation_->precision; }

Estimate PlaneEstimator::estimate(const Points& source, const Points& target, const Points& normals)
{
  if (source.count != target.count || source.count != normals.count)
    throw InvalidArgument("point-to-plane pairs need as many source points (" + std::to_string(source.count) +
                          ") as target points (" + std::to_string(target.count) + ") and normals (" +
                          std::to_string(normals.count) + ")");
  Implementation& self = *implementation_;
  const auto pivot = search::pivotOf(target);
  std::vector<PlacedPoint> p, q;
  for (std::size_t i = 0; i < source.count; ++i)
    if (isFinite(source[i]) && isFinite(target[i]) && isFinite(normals[i])) {
      p.push_back(placed(source[i], pivot, p.size()));
      q.push_back(placed(target[i], pivot, normals.position(i)));
    }
  if (p.empty()) {
    Estimate nothing;
    nothing.degeneracy = Degeneracy::Empty;
    return nothing;
  }
  // Each source point's match is the target point in the same place.
  stages::packSource(self.queue, p, self.source);
  stages::packLeaves(self.queue, q, self.target);
  self.queue.upload(self.matches, self.source.stride * sizeof(cl_int), [&](void* memory) {
    auto* matches = static_cast<cl_int*>(memory);
    std::iota(matches, matches + p.size(), 0);
    std::fill(matches + p.size(), matches + self.source.stride, -1);
  });
  self.increment.setTargetNormals(self.queue, q, pivot, normals);
  self.increment.setSource(p);
  Estimate estimate = self.increment.estimate(self.queue, self.precision, self.source, {}, self.matches, self.target);
  estimate.pairs = p.size();
  estimate.stages.source_pivot = estimate.stages.target_pivot = pivot;
  estimate.transform = absoluteTransform(estimate.stages);
  return estimate;
}

StageTimes PlaneEstimator::takeTimes()
{
  StageTimes times;
  for (const auto& [what, entry] : implementation_->queue.takeProfile().entries)
    times[what] = {entry.milliseconds, entry.count};
  return times;
}

} // namespace pcl_gpu_icp
