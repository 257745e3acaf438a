#pragma once

#include "opencl/queue.h"

#include <pcl_gpu_icp/result.h>

namespace pcl_gpu_icp::stages {

/// Stage 5: R = V diag(1, 1, det(V U^T)) U^T and t = mu_q - R mu_p.
class RotationTranslation {
public:
  /// 27 = 3^3 work-items for the scalar products of R, 9 for their sums, 3 for t.
  static StageRequest request();

  /// Reads centroids, U and V from the solution, writes R and t.
  void enqueue(opencl::Queue& queue, const opencl::Buffer& solution);
};

} // namespace pcl_gpu_icp::stages
