#pragma once

#include "opencl/queue.h"

#include <cstddef>

namespace pcl_gpu_icp::stages {

/// n matched pairs on the device: PAIR_ROWS rows of `stride` floats (see kernels/layout.h), each cloud about its pivot.
struct Pairs {
  opencl::Buffer rows{"point pairs"};
  cl_uint stride = 0;
  cl_uint count = 0;
  /// Variance below which an extent is only rounding of the coordinates, in the points' unit squared.
  float resolution_sq = 0;
};

/// A cloud on the device: 3 rows of `stride` floats about a pivot.
struct Cloud {
  opencl::Buffer rows{"cloud"};
  cl_uint stride = 0;
  cl_uint count = 0;
};

/// Row length for n points.
cl_uint paddedStride(std::size_t n);

} // namespace pcl_gpu_icp::stages
