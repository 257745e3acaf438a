#pragma once

#include <pcl_gpu_icp/points.h>

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

namespace pcl_gpu_icp::search {

/// Of the points of a cloud within a radius of a place.
struct Nearby {
  std::size_t count = 0;
  double nearest_sq = std::numeric_limits<double>::infinity();

  /// \param v the point about the place, in radii
  void add(const std::array<double, 3>& /*v*/, double squared_distance);
  void add(const Nearby& more);
};

/// And how they lie.
struct Surroundings : Nearby {
  std::array<double, 3> sum{};     ///< of the points about the place, in radii,
  std::array<double, 6> squares{}; ///< and of their outer products: xx xy yy xz yz zz

  void add(const std::array<double, 3>& v, double squared_distance);
  void add(const Surroundings& more);
};

/// Of each of a few places, in one pass over the cloud: no tree is built. The same bits for any number of threads.
/// \tparam Found Nearby or Surroundings
template <typename Found>
std::vector<Found> foundAround(const std::vector<std::array<double, 3>>& places,
                               const std::vector<PlacedPoint>& cloud,
                               double radius,
                               unsigned threads);

} // namespace pcl_gpu_icp::search
