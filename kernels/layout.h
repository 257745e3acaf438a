// Layouts shared by the host (C++17) and the device (OpenCL C 1.2). Matrices are 3x3, row-major.
#ifndef PCL_GPU_ICP_LAYOUT_H
#define PCL_GPU_ICP_LAYOUT_H

// Points summed into one partial result. A constant, so that the order of a sum depends on the number of points only.
#define POINTS_PER_BLOCK 2048

// Rows of a buffer of pairs: source x y z, target x y z, each as long as the buffer's stride.
#define PAIR_ROWS 6
// Rows of pairs are padded with zeros to a multiple of this, so that vector loads need no guard.
#define ROW_PADDING 16

// Sums of one block: 3 of p, 3 of q, 9 of p q^T (row-major), 1 of padding.
#define SUMS_PER_BLOCK 16

#ifdef __OPENCL_VERSION__
typedef struct {
#else
template <typename real>
struct RigidSolution {
#endif
  real source_centroid[3]; // about the source's pivot
  real target_centroid[3]; // about the target's pivot
  real H[9];               // cross-covariance, sum of p' q'^T
  real U[9];
  real S[3]; // singular values, largest first
  real V[9];
  real R[9];
  real t[3]; // between the two pivots' frames
  int rank;  // singular values above the coordinates' own rounding
#ifdef __OPENCL_VERSION__
} RigidSolution;
#else
};
#endif

#endif
