#include <pcl_gpu_icp/neighbour_search.h>

#include "neighbour_search_internals.h"
#include "search/box_tree_query.h"
#include "stages/launch.h"
#include "stages/nearest.h"

#include <pcl_gpu_icp/parallel_for.h>
#include <pcl_gpu_icp/search/nearest_index.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

namespace pcl_gpu_icp {

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

static_assert(NeighbourSearch::most_on_device == NEAREST_MOST, "the kernel's own limit");

bool isFinite(const float* xyz) { return std::isfinite(xyz[0]) && std::isfinite(xyz[1]) && std::isfinite(xyz[2]); }

/// What answers batches.
struct OnDevice {
  OnDevice(const Device& device, const opencl::Traits& traits)
  : queue(device, traits, stages::buildOptions(traits, Precision::Float))
  {
  }

  opencl::Queue queue;
  bool holds_tree = false;
  stages::TargetPoints target;
  stages::SourcePoints queries;
  stages::Nearest stage;
};

} // namespace

struct NeighbourSearch::Implementation {
  std::array<float, 3> aboutPivot(const float* xyz) const
  {
    return {xyz[0] - static_cast<float>(pivot[0]),
            xyz[1] - static_cast<float>(pivot[1]),
            xyz[2] - static_cast<float>(pivot[2])};
  }

  Neighbours named(const std::vector<search::Found>& found) const
  {
    Neighbours neighbours;
    for (const search::Found& one : found) {
      neighbours.positions.push_back(points[one.place].position);
      neighbours.squared_distances.push_back(one.squared_distance);
    }
    return neighbours;
  }

  std::optional<Device> device;
  std::optional<opencl::Traits> traits; ///< instead of the device's own
  std::array<double, 3> pivot{};
  std::vector<PlacedPoint> points; ///< in the order of the leaves
  std::unique_ptr<search::BoxTree> tree;
  std::mutex mutex; ///< of what follows
  std::unique_ptr<OnDevice> on_device;
};

NeighbourSearch::NeighbourSearch(std::optional<Device> device)
: implementation_(std::make_unique<Implementation>())
{
  implementation_->device = std::move(device);
}
NeighbourSearch::~NeighbourSearch() = default;
NeighbourSearch::NeighbourSearch(NeighbourSearch&&) noexcept = default;
NeighbourSearch& NeighbourSearch::operator=(NeighbourSearch&&) noexcept = default;

NeighbourSearch makeNeighbourSearch(const Device& device, const opencl::Traits& traits)
{
  NeighbourSearch search(device);
  search.implementation_->traits = traits;
  return search;
}

void NeighbourSearch::build(const Points& points)
{
  Implementation& self = *implementation_;
  const unsigned threads = effectiveThreads(0);
  self.pivot = search::pivotOf(points);
  self.points = search::finitePoints(points, self.pivot, threads);
  search::sortIntoLeaves(self.points, threads);
  self.tree = std::make_unique<search::BoxTree>(self.points, threads);
  if (self.on_device)
    self.on_device->holds_tree = false;
}

std::size_t NeighbourSearch::size() const { return implementation_->points.size(); }

Neighbours NeighbourSearch::nearest(const float* xyz, std::size_t k) const
{
  const Implementation& self = *implementation_;
  if (!self.tree || !isFinite(xyz))
    return {};
  return self.named(search::nearestPoints(*self.tree, self.aboutPivot(xyz).data(), k, infinity));
}

Neighbours NeighbourSearch::within(const float* xyz, double radius, std::size_t most, bool sorted) const
{
  const Implementation& self = *implementation_;
  if (!self.tree || !isFinite(xyz))
    return {};
  const auto radius_sq = static_cast<float>(radius * radius);
  const auto query = self.aboutPivot(xyz);
  if (most > 0 && most < self.points.size())
    return self.named(search::nearestPoints(*self.tree, query.data(), most, radius_sq));
  auto found = search::pointsWithin(*self.tree, query.data(), radius_sq);
  if (sorted)
    std::sort(found.begin(), found.end(), [](const search::Found& a, const search::Found& b) {
      return a.squared_distance < b.squared_distance;
    });
  return self.named(found);
}

std::vector<Neighbours> NeighbourSearch::nearest(const Points& queries, std::size_t k) const
{
  Implementation& self = *implementation_;
  std::vector<Neighbours> answers(queries.count);
  if (!self.tree || k == 0)
    return answers;
  const unsigned threads = effectiveThreads(0);
  if (k > most_on_device) {
    parallelFor(queries.count, search::queries_at_a_time, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        answers[i] = nearest(queries[i], k);
    });
    return answers;
  }

  std::vector<PlacedPoint> sorted;
  for (std::size_t i = 0; i < queries.count; ++i)
    if (isFinite(queries[i])) {
      const auto q = self.aboutPivot(queries[i]);
      sorted.push_back({{q[0], q[1], q[2]}, static_cast<std::int32_t>(i)});
    }
  if (sorted.empty())
    return answers;
  search::sortIntoLeaves(sorted, threads);

  const std::lock_guard<std::mutex> lock(self.mutex);
  if (!self.on_device) {
    if (!self.device)
      self.device = Device::select();
    self.on_device =
        std::make_unique<OnDevice>(*self.device, self.traits ? *self.traits : opencl::Traits::of(self.device->info()));
  }
  OnDevice& on_device = *self.on_device;
  if (!on_device.holds_tree) {
    stages::packTree(on_device.queue, *self.tree, on_device.target);
    on_device.holds_tree = true;
  }
  stages::packSource(on_device.queue, sorted, on_device.queries);
  const auto found_at_most = std::min(k, self.points.size());
  on_device.stage.enqueue(on_device.queue, on_device.queries, on_device.target, static_cast<cl_uint>(found_at_most));
  const std::size_t stride = on_device.queries.stride, entries = found_at_most * stride;
  const auto each = [&](const auto& use) {
    parallelFor(sorted.size(), search::queries_at_a_time, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        use(i, answers[sorted[i].position]);
    });
  };
  on_device.queue.download(on_device.stage.positions(), entries * sizeof(cl_int), [&](const void* memory) {
    const auto* places = static_cast<const cl_int*>(memory);
    each([&](std::size_t i, Neighbours& answer) {
      for (std::size_t row = 0; row < found_at_most && places[i + row * stride] >= 0; ++row)
        answer.positions.push_back(self.points[places[i + row * stride]].position);
    });
  });
  on_device.queue.download(on_device.stage.squaredDistances(), entries * sizeof(float), [&](const void* memory) {
    const auto* distances = static_cast<const float*>(memory);
    each([&](std::size_t i, Neighbours& answer) {
      for (std::size_t row = 0; row < answer.positions.size(); ++row)
        answer.squared_distances.push_back(distances[i + row * stride]);
    });
  });
  return answers;
}

} // namespace pcl_gpu_icp
