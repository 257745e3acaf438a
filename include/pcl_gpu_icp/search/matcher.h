#pragma once

#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_transform.h>
#include <pcl_gpu_icp/search/nearest_index.h>

#include <vector>

namespace pcl_gpu_icp::search {

/// Queries a thread takes at a time: many against the cost of taking, few against their uneven times.
constexpr std::size_t queries_at_a_time = 512;

/// Finds, iteration after iteration, each source point's nearest target point. Starts every query from the neighbour
/// of the iteration before, which changes nothing but the time.
class PCL_GPU_ICP_API Matcher {
public:
  /// \param source views the points to match; must stay valid
  /// \param target views the cloud that `target_index` was built from
  /// \param max_squared_distance pairs farther apart are left out
  Matcher(const Points& source,
          const Points& target,
          const NearestIndex& target_index,
          float max_squared_distance,
          unsigned threads);

  /// Keeps only pairs of which the source point is also the target point's nearest source point, within the limit.
  void requireReciprocal();

  /// Correspondences of the finite source points at `pose`, in the order of the source.
  const std::vector<Correspondence>& match(const RigidTransform& pose);

private:
  Points source_, target_;
  const NearestIndex& target_index_;
  float max_squared_distance_;
  unsigned threads_;
  bool reciprocal_ = false;
  NearestIndex source_index_; ///< built when reciprocal
  std::vector<Neighbour> neighbours_;
  std::vector<Correspondence> correspondences_;
};

/// Root mean square distance between pose(source) and target points of the correspondences; 0 when there are none.
PCL_GPU_ICP_API double rootMeanSquareDistance(const std::vector<Correspondence>& correspondences,
                                              const Points& source,
                                              const Points& target,
                                              const RigidTransform& pose);

} // namespace pcl_gpu_icp::search
