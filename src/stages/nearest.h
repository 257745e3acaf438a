#pragma once

#include "match.h"

namespace pcl_gpu_icp::stages {

/// The k nearest target points of every query.
class Nearest {
public:
  /// \param queries in the target's frame
  /// \param k at most NEAREST_MOST
  void enqueue(opencl::Queue& queue, const SourcePoints& queries, const TargetPoints& target, cl_uint k);

  /// k rows of the queries' stride: positions in the target's leaves, nearest first; -1 where there are fewer points.
  const opencl::Buffer& positions() const { return positions_; }
  /// The same of squared distances.
  const opencl::Buffer& squaredDistances() const { return squared_distances_; }

private:
  opencl::Buffer positions_{"neighbours found"};
  opencl::Buffer squared_distances_{"their distances"};
};

} // namespace pcl_gpu_icp::stages
