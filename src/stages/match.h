#pragma once

#include "opencl/queue.h"
#include "search/box_tree_query.h"

#include <pcl_gpu_icp/rigid_transform.h>

#include <functional>

namespace pcl_gpu_icp::stages {

/// The target's points in leaves; where the device searches, in the order of the tree and with its boxes. See
/// kernels/tree.h.
struct TargetPoints {
  opencl::Buffer leaves{"target points"};
  opencl::Buffer nodes{"target tree"};
  cl_uint8 first_node{};
  cl_uint root_level = 0;
};

/// Copies points to leaves in their order.
void packLeaves(opencl::Queue& queue, const std::vector<PlacedPoint>& points, TargetPoints& target);

/// Copies a tree.
void packTree(opencl::Queue& queue, const search::BoxTree& tree, TargetPoints& target);

/// Source points: rows x, y, z of `stride` floats. Points that are close together should be close in the rows.
struct SourcePoints {
  opencl::Buffer rows{"source points"};
  cl_uint stride = 0;
  cl_uint count = 0;
};
void packSource(opencl::Queue& queue, const std::vector<PlacedPoint>& sorted, SourcePoints& source);

/// How matches are searched for.
struct SearchEffort {
  float limit_sq = 0; ///< matches are nearer than this
  float slack = 0;    ///< points this much farther than the nearest are looked for, too
  cl_uint kept = 1;   ///< how many of them are kept, at most KEPT_CANDIDATES
};

/// A point to search for on the host, and the squared distance to search within.
struct Query {
  float xyz[3];
  float radius_sq;
};

/// Answers queries with KEPT_CANDIDATES rows of `count` positions in the leaves (-1: none), and two rows of the
/// distances from the query within which there is nothing but the nearest, and nothing but all of them.
using HostSearch = std::function<void(const Query* queries, std::size_t count, cl_int* positions, float* reaches)>;

/// For every source point its nearest target point; the sums over the pairs; what the five stages make of them.
class Match {
public:
  /// Forgets what is known of the source points.
  void restart(opencl::Queue& queue, const SourcePoints& source);

  /// Matches and sums in one pass.
  /// \param pose from the source's frame (about its pivot) to the target's
  void searchOnDevice(opencl::Queue& queue,
                      const SourcePoints& source,
                      const TargetPoints& target,
                      const RigidTransform& pose,
                      const SearchEffort& effort,
                      std::size_t real_bytes);

  /// Matches; `search` is asked for the points whose match may have changed.
  /// \return how many they were
  std::size_t searchOnHost(opencl::Queue& queue,
                           const SourcePoints& source,
                           const TargetPoints& target,
                           const RigidTransform& pose,
                           const SearchEffort& effort,
                           const HostSearch& search);

  /// Sums over the matches, with the source at a pose that may be another.
  void sum(opencl::Queue& queue,
           const SourcePoints& source,
           const TargetPoints& target,
           const RigidTransform& pose,
           std::size_t real_bytes);

  /// Writes the whole MatchSummary from the sums.
  void solve(opencl::Queue& queue, const SourcePoints& source, float resolution_sq, const opencl::Buffer& summary);

  /// For each source point the position of its match in the target's leaves, or -1.
  const opencl::Buffer& matches() const { return matches_; }

private:
  template <typename... Arguments>
  void launch(opencl::Queue& queue,
              const char* kernel,
              const SourcePoints& source,
              const RigidTransform& pose,
              const Arguments&... arguments);
  /// That nothing is known of any source point, also of those that are not searched for at first.
  void writeIgnorance(opencl::Queue& queue, const SourcePoints& source);
  void reserveSums(opencl::Queue& queue, const SourcePoints& source, std::size_t real_bytes);

  opencl::Buffer searched_at_{"matching memory"};
  opencl::Buffer candidates_{"kept candidates"};
  opencl::Buffer matches_{"matches"};
  cl_uint tested_ = 0; ///< the most candidates any point has
  opencl::Buffer partials_{"partial sums"};
  opencl::Buffer tallies_{"tallies"};
  opencl::Buffer queries_{"queries"};
  opencl::Buffer queried_{"points to search for"};
  opencl::Buffer answers_{"neighbours found"};
};

} // namespace pcl_gpu_icp::stages
