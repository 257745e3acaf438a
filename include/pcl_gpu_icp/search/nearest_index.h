#pragma once

#include <pcl_gpu_icp/export.h>
#include <pcl_gpu_icp/points.h>

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace pcl_gpu_icp::search {

/// Queries a thread takes at a time: many against the cost of taking, few against their uneven times.
constexpr std::size_t queries_at_a_time = 512;

/// The nearest point found, or none.
struct Neighbour {
  std::int32_t index = -1; ///< position in the indexed cloud; -1: none within the limit
  float squared_distance = std::numeric_limits<float>::infinity();
};

/// The nearest few points, nearest first.
struct Neighbourhood {
  static constexpr unsigned most = 4;
  std::array<std::int32_t, most> rows{-1, -1, -1, -1}; ///< places in NearestIndex::points(); -1: none
  std::array<float, most> squared_distances;           ///< ascending; infinite: none
  float bound_sq;                                      ///< every other point is at least so far
};

/// Exact nearest neighbours on the host: the FLANN KD-tree that pcl::KdTreeFLANN wraps, built with the same
/// parameters, but queried without an OpenMP region or a result allocation per query, and with coincident points
/// counted once (FLANN would visit every one of them). Non-finite points are left out. Queries are thread-safe.
class PCL_GPU_ICP_API NearestIndex {
public:
  NearestIndex();
  ~NearestIndex();
  NearestIndex(NearestIndex&&) noexcept;
  NearestIndex& operator=(NearestIndex&&) noexcept;

  /// Copies the coordinates of `points` and builds the tree. An index found later is Points::position().
  void build(const Points& points);

  /// Distinct finite points.
  std::size_t size() const { return points().size(); }

  /// Those points, about pivot().
  const std::vector<PlacedPoint>& points() const;
  const std::array<double, 3>& pivot() const;

  /// The typical distance between neighbours among them; 0 when there are too few to tell.
  float spacing() const;

  /// The nearest point closer than or at the limit. Of coincident points the first.
  Neighbour nearest(const float* xyz, float max_squared_distance = std::numeric_limits<float>::infinity()) const;

  /// The nearest few points closer than `radius_sq`, up to `slack` farther than the nearest of them.
  /// \param query about pivot()
  /// \param kept how many, at most Neighbourhood::most
  Neighbourhood neighbourhood(const float* query, float radius_sq, float slack, unsigned kept) const;

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// 64 bits that change when a coordinate, the number or the order of the points changes.
PCL_GPU_ICP_API std::uint64_t fingerprintOf(const Points& points);

} // namespace pcl_gpu_icp::search
