#include <pcl_gpu_icp/rigid_estimator.h>

#include "estimator_internals.h"
#include "kernels/layout.h"
#include "solution.h"
#include "stages/centroid.h"
#include "stages/cross_covariance.h"
#include "stages/demean.h"
#include "stages/gather.h"
#include "stages/launch.h"
#include "stages/listed_pairs.h"
#include "stages/pack.h"
#include "stages/rigid_transform.h"
#include "stages/svd.h"

#include <pcl_gpu_icp/error.h>

#include <algorithm>

namespace pcl_gpu_icp {

namespace {

/// The kernels index the 9 rows of outer products with 32 bits.
constexpr std::size_t points_at_most = (std::size_t(1) << 32) / 9 / ROW_PADDING * ROW_PADDING;

void checkCount(std::size_t count)
{
  if (count > points_at_most)
    throw InvalidArgument(std::to_string(count) + " points are more than the kernels can index (" +
                          std::to_string(points_at_most) + ")");
}

} // namespace

struct RigidEstimator::Implementation {
  Implementation(const Device& device,
                 const opencl::Traits& traits,
                 Pipeline wanted_pipeline,
                 Precision wanted_precision)
  : pipeline(wanted_pipeline)
  , precision(stages::available(wanted_precision, traits))
  , queue(device, traits, stages::buildOptions(traits, precision))
  {
  }

  std::size_t realBytes() const { return precision == Precision::Double ? sizeof(double) : sizeof(float); }

  Estimate solve()
  {
    Estimate estimate;
    estimate.pairs = pairs.count;
    if (pairs.count == 0) {
      estimate.degeneracy = Degeneracy::Empty;
      return estimate;
    }
    queue.reserve(solution,
                  precision == Precision::Double ? sizeof(RigidSolution<double>) : sizeof(RigidSolution<float>));
    if (pipeline == Pipeline::Fused)
      listed.enqueue(queue, pairs, realBytes(), solution);
    else {
      centroid.enqueue(queue, pairs, realBytes(), solution);
      demean.enqueue(queue, pairs, realBytes(), solution);
      cross_covariance.enqueue(queue, pairs, demean.demeaned(), realBytes(), solution);
      svd.enqueue(queue, pairs, solution);
      rotation_translation.enqueue(queue, solution);
    }
    if (precision == Precision::Double)
      read<double>(estimate);
    else
      read<float>(estimate);
    return estimate;
  }

  template <typename real>
  void read(Estimate& estimate)
  {
    queue.download(solution, sizeof(RigidSolution<real>), [&](const void* memory) {
      copySolution(*static_cast<const RigidSolution<real>*>(memory), estimate);
    });
    requireFinite(estimate, precision);
  }

  Pipeline pipeline;
  Precision precision;
  opencl::Queue queue;
  stages::Cloud source, target;
  stages::Placement source_placement, target_placement;
  stages::Pairs pairs;
  stages::Gather gather;
  stages::ListedPairs listed;
  stages::Centroid centroid;
  stages::Demean demean;
  stages::CrossCovariance cross_covariance;
  stages::Svd svd;
  stages::RotationTranslation rotation_translation;
  opencl::Buffer solution{"solution"};
};

RigidEstimator::RigidEstimator(const Device& device, Pipeline pipeline, Precision precision)
: RigidEstimator(makeEstimator(device, opencl::Traits::of(device.info()), pipeline, precision))
{
}

RigidEstimator::RigidEstimator(std::unique_ptr<Implementation> implementation)
: implementation_(std::move(implementation))
{
}

RigidEstimator::~RigidEstimator() = default;
RigidEstimator::RigidEstimator(RigidEstimator&&) noexcept = default;
RigidEstimator& RigidEstimator::operator=(RigidEstimator&&) noexcept = default;

RigidEstimator makeEstimator(const Device& device, const opencl::Traits& traits, Pipeline pipeline, Precision precision)
{
  RigidEstimator estimator(std::make_unique<RigidEstimator::Implementation>(device, traits, pipeline, precision));
  estimator.warmUp();
  return estimator;
}

void RigidEstimator::warmUp()
{
  const float points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const Points cloud{points, 3, 3 * sizeof(float)};
  const Correspondence pairs[] = {{0, 0, 0}, {1, 1, 0}, {2, 2, 0}};
  setSource(cloud);
  setTarget(cloud);
  estimate(pairs, 3, RigidTransform{});
  takeTimes();
}

const DeviceInfo& RigidEstimator::device() const { return implementation_->queue.info(); }
Pipeline RigidEstimator::pipeline() const { return implementation_->pipeline; }
Precision RigidEstimator::precision() const { return implementation_->precision; }
const std::array<double, 3>& RigidEstimator::sourcePivot() const { return implementation_->source_placement.pivot; }

void RigidEstimator::setShare(std::shared_ptr<DeviceShare> share) { implementation_->queue.setShare(std::move(share)); }

Estimate RigidEstimator::estimate(const Points& source, const Points& target)
{
  if (source.count != target.count)
    throw InvalidArgument("pairs need as many source points (" + std::to_string(source.count) + ") as target points (" +
                          std::to_string(target.count) + ")");
  checkCount(source.count);
  Implementation& self = *implementation_;
  const stages::Placement p = stages::placementOf(source), q = stages::placementOf(target);
  self.pairs.count = 0;
  if (source.count > 0)
    stages::packPairs(self.queue, source, target, p, q, self.pairs);
  Estimate estimate = self.solve();
  estimate.stages.source_pivot = p.pivot;
  estimate.stages.target_pivot = q.pivot;
  if (estimate.pairs > 0)
    estimate.transform = absoluteTransform(estimate.stages);
  return estimate;
}

void RigidEstimator::setSource(const Points& source)
{
  checkCount(source.count);
  Implementation& self = *implementation_;
  self.source_placement = stages::placementOf(source);
  stages::packCloud(self.queue, source, self.source_placement, self.source);
}

void RigidEstimator::setTarget(const Points& target)
{
  checkCount(target.count);
  Implementation& self = *implementation_;
  self.target_placement = stages::placementOf(target);
  stages::packCloud(self.queue, target, self.target_placement, self.target);
}

Estimate RigidEstimator::estimate(const Correspondence* correspondences, std::size_t count, const RigidTransform& pose)
{
  checkCount(count);
  Implementation& self = *implementation_;
  const auto inside = [&](const Correspondence& c) {
    return c.source >= 0 && cl_uint(c.source) < self.source.count && c.target >= 0 &&
           cl_uint(c.target) < self.target.count;
  };
  const auto stray = std::find_if_not(correspondences, correspondences + count, inside);
  if (stray != correspondences + count)
    throw InvalidArgument("a correspondence names points (" + std::to_string(stray->source) + ", " +
                          std::to_string(stray->target) + ") of clouds of " + std::to_string(self.source.count) +
                          " and " + std::to_string(self.target.count) + " points");
  self.pairs.count = 0;
  self.pairs.resolution_sq = self.source_placement.rounding * self.target_placement.rounding;
  const DevicePose device_pose(pose, self.source_placement.pivot, self.target_placement.pivot);
  if (count > 0)
    self.gather.enqueue(
        self.queue, self.source, self.target, correspondences, count, device_pose.pivoted(), self.pairs);
  Estimate estimate = self.solve();
  device_pose.completeIncrement(estimate);
  return estimate;
}

std::vector<double> RigidEstimator::demeaned() const
{
  Implementation& self = *implementation_;
  if (self.pipeline != Pipeline::Staged)
    throw InvalidArgument("only the staged pipeline forms de-meaned points");
  std::vector<double> rows;
  if (self.pairs.count == 0)
    return rows;
  const auto copy = [&](const auto* values) {
    for (int row = 0; row < PAIR_ROWS; ++row)
      rows.insert(rows.end(), values + row * self.pairs.stride, values + row * self.pairs.stride + self.pairs.count);
  };
  self.queue.download(
      self.demean.demeaned(), std::size_t(PAIR_ROWS) * self.pairs.stride * self.realBytes(), [&](const void* memory) {
        if (self.precision == Precision::Double)
          copy(static_cast<const double*>(memory));
        else
          copy(static_cast<const float*>(memory));
      });
  return rows;
}

std::size_t RigidEstimator::deviceBytes() const { return implementation_->queue.allocated(); }

StageTimes RigidEstimator::takeTimes()
{
  StageTimes times;
  for (const auto& [what, entry] : implementation_->queue.takeProfile().entries)
    times[what] = {entry.milliseconds, entry.count};
  return times;
}

} // namespace pcl_gpu_icp
