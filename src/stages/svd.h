#pragma once

#include "pairs.h"

#include <pcl_gpu_icp/result.h>

namespace pcl_gpu_icp::stages {

/// Stage 4: H = U S V^T from the eigenvectors of H^T H, with a defined answer for every rank.
class Svd {
public:
  /// 27 = 3^3 work-items for the scalar products of H^T H, 9 for their sums, 1 for the eigenvectors.
  static StageRequest request();

  /// Reads H from the solution, writes U, S, V and the rank.
  void enqueue(opencl::Queue& queue, const Pairs& pairs, const opencl::Buffer& solution);
};

} // namespace pcl_gpu_icp::stages
