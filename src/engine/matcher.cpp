#include <pcl_gpu_icp/matcher.h>

#include "matcher_implementation.h"
#include "matcher_internals.h"
#include "search/box_tree.h"
#include "values_at.h"

#include <pcl_gpu_icp/error.h>
#include <pcl_gpu_icp/parallel_for.h>

#include <string>
#include <utility>

namespace pcl_gpu_icp {

namespace {

void requireOneEach(const std::vector<PlacedPoint>& points, std::size_t count, const char* values)
{
  for (const PlacedPoint& point : points)
    pcl_gpu_icp::requireOneEach(point.position, count, values);
}

} // namespace

Matcher::Matcher(const Device& device,
                 CorrespondenceSearch search,
                 Precision precision,
                 Metric metric,
                 const Loss& loss,
                 Motions motions)
: Matcher(makeMatcher(device, opencl::Traits::of(device.info()), precision))
{
  const float points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const Points cloud{points, 3, 3 * sizeof(float)};
  if (search == CorrespondenceSearch::PclKdTree) {
    const auto index = std::make_shared<search::NearestIndex>();
    index->build(cloud);
    setTarget(makeTarget(index));
  }
  else
    setTarget(makeTarget(cloud));
  setSource(cloud);
  if (metric == Metric::Plane || metric == Metric::Symmetric)
    setTargetNormals(cloud);
  if (metric == Metric::Symmetric)
    setSourceNormals(cloud);
  if (metric == Metric::Generalized) {
    constexpr std::array<float, COVARIANCE_ROWS> identity{1, 0, 0, 1, 0, 1};
    const Points covariances{identity.data(), 3, 0};
    setTargetCovariances(covariances);
    setSourceCovariances(covariances);
  }
  setLoss(loss);
  setMotions(motions);
  match({}, 1);
  meanSquaredDistance({});
  takeTimes();
}
Matcher::Matcher(std::unique_ptr<Implementation> implementation)
: implementation_(std::move(implementation))
{
}
Matcher::~Matcher() = default;
Matcher::Matcher(Matcher&&) noexcept = default;
Matcher& Matcher::operator=(Matcher&&) noexcept = default;

Matcher makeMatcher(const Device& device, const opencl::Traits& traits, Precision precision)
{
  return Matcher(std::make_unique<Matcher::Implementation>(device, traits, precision));
}

const DeviceInfo& Matcher::device() const { return implementation_->queue.info(); }
Precision Matcher::precision() const { return implementation_->precision; }
void Matcher::setShare(std::shared_ptr<DeviceShare> share) { implementation_->queue.setShare(std::move(share)); }
void Matcher::setNumberOfThreads(unsigned threads) { implementation_->threads = threads; }
std::size_t Matcher::targetSize() const { return implementation_->target->cloud.points.size(); }
const std::array<double, 3>& Matcher::sourcePivot() const { return implementation_->source.pivot; }

std::shared_ptr<const MatchTarget> Matcher::makeTarget(const Points& target) const
{
  const unsigned threads = effectiveThreads(implementation_->threads);
  auto made = std::make_shared<MatchTarget>();
  auto& points = made->cloud.points;
  made->cloud.place(target, threads);
  search::dropCoincident(points);
  search::sortIntoLeaves(points, threads);
  made->spacing = search::spacingOf(points);
  implementation_->fill(
      *made, [&](opencl::Queue& queue) { stages::packTree(queue, search::BoxTree(points, threads), made->on_device); });
  return made;
}

std::shared_ptr<const MatchTarget> Matcher::makeTarget(std::shared_ptr<const search::NearestIndex> index) const
{
  auto made = std::make_shared<MatchTarget>();
  made->cloud.place(*index);
  made->spacing = index->spacing();
  implementation_->fill(*made,
                        [&](opencl::Queue& queue) { stages::packLeaves(queue, index->points(), made->on_device); });
  made->index = std::move(index);
  return made;
}

void Matcher::setTarget(std::shared_ptr<const MatchTarget> target)
{
  Implementation& self = *implementation_;
  self.system.reset();
  self.paired = nullptr;
  self.target = std::move(target);
  self.stage.restart(self.queue, self.source_rows);
}

void Matcher::setTargetNormals(const Points& normals)
{
  Implementation& self = *implementation_;
  const PlacedCloud& target = self.target->cloud;
  requireOneEach(target.points, normals.count, "normals");
  self.measureBy(
      [&](SystemIncrement& system) { system.setTargetNormals(self.queue, target.points, target.pivot, normals); });
}

void Matcher::setTargetCovariances(const Points& covariances)
{
  Implementation& self = *implementation_;
  const PlacedCloud& target = self.target->cloud;
  requireOneEach(target.points, covariances.count, "covariances of the target");
  self.measureBy([&](SystemIncrement& system) {
    system.setTargetCovariances(self.queue, target.points, target.pivot, covariances);
  });
}

void Matcher::setSourceNormals(const Points& normals)
{
  Implementation& self = *implementation_;
  const bool follow =
      self.system && (self.system->metric() == Metric::Plane || self.system->metric() == Metric::Symmetric);
  const auto in_order = self.inSourceOrder<NORMAL_ROWS>(normals, follow, "normals of the source");
  self.system->setSourceNormals(self.queue, in_order, self.source_rows);
}

void Matcher::setSourceCovariances(const Points& covariances)
{
  Implementation& self = *implementation_;
  const bool follow = self.system && self.system->metric() == Metric::Generalized;
  const auto in_order = self.inSourceOrder<COVARIANCE_ROWS>(covariances, follow, "covariances of the source");
  self.system->setSourceCovariances(self.queue, in_order, self.source_rows);
}

void Matcher::setLoss(const Loss& loss)
{
  requireValid(loss);
  implementation_->objective.loss = loss;
}

void Matcher::setMotions(Motions motions) { implementation_->objective.motions = motions; }

void Matcher::setSteps(int most) { implementation_->objective.steps = most; }

void Matcher::setSource(const Points& source)
{
  Implementation& self = *implementation_;
  const unsigned threads = effectiveThreads(self.threads);
  self.source.place(source, threads);
  auto& points = self.source.points;
  self.source_positions.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    self.source_positions[i] = std::exchange(points[i].position, static_cast<std::int32_t>(i));
  search::sortIntoLeaves(points, threads);
  stages::packSource(self.queue, points, self.source_rows);
  self.motion.restart(points);
  if (self.system)
    self.system->setSource(points);
  self.paired = nullptr;
  self.stage.restart(self.queue, self.source_rows);
}

Matches Matcher::match(const RigidTransform& pose, float max_squared_distance, bool with_increment)
{
  if (!(max_squared_distance >= 0))
    throw InvalidArgument("a squared distance within which to match is at least 0, not " +
                          std::to_string(max_squared_distance));
  Implementation& self = *implementation_;
  const DevicePose device_pose = self.onDevice(pose);
  const RigidTransform& pivoted = device_pose.pivoted();
  Matches matches;
  if (self.source_rows.count > 0) {
    const stages::SearchEffort effort = self.effortFor(pivoted, max_squared_distance);
    if (!self.target->index) {
      self.stage.searchOnDevice(
          self.queue, self.source_rows, self.target->on_device, pivoted, effort, self.realBytes());
      matches = self.solution();
    }
    else {
      const auto search = [&](const stages::Query* queries, std::size_t count, cl_int* positions, float* reaches) {
        self.target->searchIndex(effort, effectiveThreads(self.threads), queries, count, positions, reaches);
      };
      const std::size_t searched =
          self.stage.searchOnHost(self.queue, self.source_rows, self.target->on_device, pivoted, effort, search);
      self.stage.sum(self.queue, self.source_rows, self.target->on_device, pivoted, self.realBytes());
      matches = self.solution();
      matches.searched = searched;
    }
  }
  else
    matches.increment.degeneracy = Degeneracy::Empty;
  matches.mean_squared_residual = matches.mean_squared_distance;
  self.paired = with_increment && matches.increment.pairs > 0 ? &self.stage.matches() : nullptr;
  if (self.paired && self.solvesSystem())
    self.solveSystem(pivoted, self.stage.matches(), matches);
  self.complete(matches.increment, device_pose);
  return matches;
}

double Matcher::meanSquaredDistance(const RigidTransform& pose)
{
  Implementation& self = *implementation_;
  if (self.source_rows.count == 0)
    return 0;
  self.stage.sum(self.queue, self.source_rows, self.target->on_device, self.onDevice(pose).pivoted(), self.realBytes());
  return self.solution().mean_squared_distance;
}

std::optional<Uncertainty> Matcher::uncertainty(const RigidTransform& pose)
{
  Implementation& self = *implementation_;
  if (self.source_rows.count == 0)
    return std::nullopt;
  auto uncertainty = self.uncertainty(self.onDevice(pose).pivoted());
  if (uncertainty)
    for (int axis = 0; axis < 3; ++axis)
      uncertainty->centre[axis] += self.target->cloud.pivot[axis];
  return uncertainty;
}

std::size_t Matcher::deviceBytes() const
{
  return implementation_->queue.allocated() + implementation_->target->device_bytes;
}

StageTimes Matcher::takeTimes()
{
  StageTimes times = std::exchange(implementation_->target_times, {});
  for (const auto& [what, entry] : implementation_->queue.takeProfile().entries) {
    times[what].milliseconds += entry.milliseconds;
    times[what].count += entry.count;
  }
  return times;
}

} // namespace pcl_gpu_icp
