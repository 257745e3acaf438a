#include <pcl_gpu_icp/search/nearest_index.h>

#include "box_tree.h"
#include "flann_allocator.h"

#include <pcl_gpu_icp/parallel_for.h>

#include <flann/algorithms/kdtree_single_index.h>

#include <algorithm>
#include <cmath>

namespace pcl_gpu_icp::search {

namespace {

/// flann::L2_Simple for three coordinates: FLANN's loop over the dimension takes a third of a query. A type of our own
/// also keeps this instantiation of FLANN's tree apart from the one in libpcl_kdtree.
struct SquaredDistance {
  using is_kdtree_distance = bool;
  using ElementType = float;
  using ResultType = float;

  template <typename Point>
  float operator()(const float* a, Point b, std::size_t /*size*/, float /*worst*/ = -1) const
  {
    const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
  }
  // NOLINTNEXTLINE(readability-identifier-naming): FLANN calls it
  float accum_dist(float a, float b, int /*axis*/) const { return (a - b) * (a - b); }
};

using Tree = flann::KDTreeSingleIndex<SquaredDistance>;

flann::SearchParams exhaustive() { return {flann::FLANN_CHECKS_UNLIMITED, 0.0F}; }

/// pcl::KdTreeFLANN's leaf size.
constexpr int leaf_max_size = 15;

/// The nearest few, on the stack. As `keep` in kernels/tree.h.
class NearestFew : public flann::ResultSet<float> {
public:
  NearestFew(float radius_sq, float slack, unsigned kept)
  : radius_sq_(radius_sq)
  , slack_(slack)
  , kept_(kept)
  {
    found_.squared_distances.fill(std::numeric_limits<float>::infinity());
    found_.bound_sq = std::numeric_limits<float>::infinity();
  }

  bool full() const override { return true; }
  float worstDist() const override { return radius_sq_; }
  void addPoint(float distance_sq, std::size_t row) override
  {
    auto& distances = found_.squared_distances;
    if (!(distance_sq < distances[kept_ - 1])) {
      found_.bound_sq = std::min(found_.bound_sq, distance_sq);
      return;
    }
    unsigned i = kept_ - 1;
    found_.bound_sq = std::min(found_.bound_sq, distances[i]);
    for (; i > 0 && distances[i - 1] > distance_sq; --i) {
      distances[i] = distances[i - 1];
      found_.rows[i] = found_.rows[i - 1];
    }
    distances[i] = distance_sq;
    found_.rows[i] = static_cast<std::int32_t>(row);
    const float reach = std::sqrt(distances[0]) + slack_;
    radius_sq_ = std::min({radius_sq_, std::max(reach * reach, distances[0]), distances[kept_ - 1]});
  }

  /// The tree tells of nothing beyond the radius.
  Neighbourhood found() const
  {
    Neighbourhood found = found_;
    found.bound_sq = std::min(found.bound_sq, radius_sq_);
    return found;
  }

private:
  float radius_sq_, slack_;
  unsigned kept_;
  Neighbourhood found_;
};

/// The median distance of a few points to their nearest neighbour.
float sampledSpacing(const Tree& tree, const std::vector<PlacedPoint>& points)
{
  constexpr std::size_t samples_at_most = 63;
  std::vector<float> distances;
  for (std::size_t i = 0; i < points.size() && points.size() > 1; i += points.size() / samples_at_most + 1) {
    NearestFew nearest(std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(), 2);
    tree.findNeighbors(nearest, points[i].xyz, exhaustive());
    distances.push_back(std::sqrt(nearest.found().squared_distances[1]));
  }
  if (distances.empty())
    return 0;
  const auto middle = distances.begin() + distances.size() / 2;
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

} // namespace

struct NearestIndex::Implementation {
  std::array<double, 3> pivot{};
  std::vector<PlacedPoint> points; ///< distinct and finite
  std::unique_ptr<Tree> tree;      ///< refers to the points
  float spacing = 0;
};

NearestIndex::NearestIndex()
: implementation_(std::make_unique<Implementation>())
{
}
NearestIndex::~NearestIndex() = default;
NearestIndex::NearestIndex(NearestIndex&&) noexcept = default;
NearestIndex& NearestIndex::operator=(NearestIndex&&) noexcept = default;

void NearestIndex::build(const Points& points)
{
  auto built = std::make_unique<Implementation>();
  built->pivot = pivotOf(points);
  built->points = finitePoints(points, built->pivot, effectiveThreads(0));
  dropCoincident(built->points);
  if (!built->points.empty()) {
    const flann::Matrix<float> rows(built->points.front().xyz, built->points.size(), 3, sizeof(PlacedPoint));
    built->tree = std::make_unique<Tree>(rows, flann::KDTreeSingleIndexParams(leaf_max_size));
    built->tree->buildIndex();
    built->spacing = sampledSpacing(*built->tree, built->points);
  }
  implementation_ = std::move(built);
}

const std::vector<PlacedPoint>& NearestIndex::points() const { return implementation_->points; }
const std::array<double, 3>& NearestIndex::pivot() const { return implementation_->pivot; }

float NearestIndex::spacing() const { return implementation_->spacing; }

Neighbour NearestIndex::nearest(const float* xyz, float max_squared_distance) const
{
  float query[3];
  for (int axis = 0; axis < 3; ++axis)
    query[axis] = xyz[axis] - static_cast<float>(implementation_->pivot[axis]);
  // The tree looks for what is strictly closer.
  const float limit = std::nextafter(max_squared_distance, std::numeric_limits<float>::infinity());
  const Neighbourhood found = neighbourhood(query, limit, 0, 1);
  if (found.rows[0] < 0)
    return {};
  return {implementation_->points[found.rows[0]].position, found.squared_distances[0]};
}

Neighbourhood NearestIndex::neighbourhood(const float* query, float radius_sq, float slack, unsigned kept) const
{
  NearestFew nearest(radius_sq, slack, kept);
  if (implementation_->tree && std::isfinite(query[0]) && std::isfinite(query[1]) && std::isfinite(query[2]))
    implementation_->tree->findNeighbors(nearest, query, exhaustive());
  return nearest.found();
}

std::uint64_t fingerprintOf(const Points& points)
{
  std::uint64_t fingerprint = points.count;
  for (std::size_t i = 0; i < points.count; ++i)
    fingerprint = fingerprint * 0xD1B54A32D192ED03ULL + hashOf(points[i]);
  return fingerprint;
}

} // namespace pcl_gpu_icp::search
