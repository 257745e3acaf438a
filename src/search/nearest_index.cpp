#include <pcl_gpu_icp/search/nearest_index.h>

#include <flann/algorithms/dist.h>
#include <flann/algorithms/kdtree_single_index.h>

#include <cmath>
#include <cstring>

namespace pcl_gpu_icp::search {

namespace {

/// A distance type of our own, so that this instantiation of FLANN's tree is not the one in libpcl_kdtree.
struct SquaredDistance : flann::L2_Simple<float> {};

using Tree = flann::KDTreeSingleIndex<SquaredDistance>;

/// pcl::KdTreeFLANN's leaf size.
constexpr int leaf_max_size = 15;

/// One neighbour, on the stack.
class Nearest : public flann::ResultSet<float> {
public:
  explicit Nearest(float limit)
  : limit_(limit)
  {
  }

  bool full() const override { return true; }
  void addPoint(float distance, std::size_t index) override
  {
    if (distance < limit_) {
      limit_ = distance;
      row_ = static_cast<std::int64_t>(index);
    }
  }
  float worstDist() const override { return limit_; }

  std::int64_t row() const { return row_; }

private:
  float limit_;
  std::int64_t row_ = -1;
};

std::size_t hashOf(const float* xyz)
{
  std::uint32_t bits[3];
  std::memcpy(bits, xyz, sizeof(bits));
  std::uint64_t hash = 0;
  for (const std::uint32_t word : bits) {
    hash = (hash ^ word) * 0x9E3779B97F4A7C15ULL;
    hash ^= hash >> 32;
  }
  return hash;
}

/// Open-addressing set of rows of coordinates, to find coincident points.
class DistinctPoints {
public:
  DistinctPoints(std::size_t capacity, const std::vector<float>& rows)
  : rows_(rows)
  {
    std::size_t slots = 16;
    while (slots < 2 * capacity)
      slots *= 2;
    slots_.assign(slots, -1);
  }

  /// Adds row `row`; false when an equal one is there.
  bool add(std::int32_t row)
  {
    const float* xyz = rows_.data() + 3 * std::size_t(row);
    for (std::size_t slot = hashOf(xyz);; ++slot) {
      std::int32_t& held = slots_[slot & (slots_.size() - 1)];
      if (held < 0) {
        held = row;
        return true;
      }
      const float* other = rows_.data() + 3 * std::size_t(held);
      if (xyz[0] == other[0] && xyz[1] == other[1] && xyz[2] == other[2])
        return false;
    }
  }

private:
  const std::vector<float>& rows_;
  std::vector<std::int32_t> slots_;
};

} // namespace

struct NearestIndex::Implementation {
  std::vector<float> coordinates;      ///< x, y, z of the distinct finite points
  std::vector<std::int32_t> positions; ///< their positions in the cloud
  std::unique_ptr<Tree> tree;          ///< refers to the coordinates
  flann::SearchParams parameters{flann::FLANN_CHECKS_UNLIMITED, 0.0F};
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
  auto& coordinates = built->coordinates;
  coordinates.reserve(3 * points.count);
  built->positions.reserve(points.count);
  DistinctPoints distinct(points.count, coordinates);
  for (std::size_t i = 0; i < points.count; ++i) {
    const float* p = points[i];
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
      continue;
    for (int axis = 0; axis < 3; ++axis)
      coordinates.push_back(p[axis] + 0.0F); // -0 and 0 are one coordinate
    if (distinct.add(static_cast<std::int32_t>(built->positions.size())))
      built->positions.push_back(static_cast<std::int32_t>(points.position(i)));
    else
      coordinates.resize(coordinates.size() - 3);
  }
  if (!built->positions.empty()) {
    const flann::Matrix<float> rows(coordinates.data(), built->positions.size(), 3);
    built->tree = std::make_unique<Tree>(rows, flann::KDTreeSingleIndexParams(leaf_max_size));
    built->tree->buildIndex();
  }
  implementation_ = std::move(built);
}

std::size_t NearestIndex::size() const { return implementation_->positions.size(); }

Neighbour NearestIndex::nearest(const float* xyz, float max_squared_distance, Neighbour start) const
{
  if (!implementation_->tree || !std::isfinite(xyz[0]) || !std::isfinite(xyz[1]) || !std::isfinite(xyz[2]))
    return {};
  // The tree looks for what is strictly closer.
  const bool started = start.index >= 0 && start.squared_distance <= max_squared_distance;
  const float infinity = std::numeric_limits<float>::infinity();
  const float limit = started ? start.squared_distance : std::nextafter(max_squared_distance, infinity);
  Nearest nearest(limit);
  implementation_->tree->findNeighbors(nearest, xyz, implementation_->parameters);
  if (nearest.row() < 0)
    return started ? start : Neighbour{};
  return {implementation_->positions[nearest.row()], nearest.worstDist()};
}

std::uint64_t fingerprintOf(const Points& points)
{
  std::uint64_t fingerprint = points.count;
  for (std::size_t i = 0; i < points.count; ++i)
    fingerprint = fingerprint * 0xD1B54A32D192ED03ULL + hashOf(points[i]);
  return fingerprint;
}

} // namespace pcl_gpu_icp::search
