#pragma once

#include <pcl_gpu_icp/export.h>
#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace pcl_gpu_icp::search {

/// The nearest point found, or none.
struct Neighbour {
  std::int32_t index = -1; ///< position in the indexed cloud; -1: none within the limit
  float squared_distance = std::numeric_limits<float>::infinity();
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
  std::size_t size() const;

  /// The nearest point closer than or at the limit. Of coincident points the first.
  /// \param start a neighbour known to be at that distance, such as last iteration's: the search begins from it
  Neighbour nearest(const float* xyz,
                    float max_squared_distance = std::numeric_limits<float>::infinity(),
                    Neighbour start = {}) const;

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// 64 bits that change when a coordinate, the number or the order of the points changes.
PCL_GPU_ICP_API std::uint64_t fingerprintOf(const Points& points);

} // namespace pcl_gpu_icp::search
