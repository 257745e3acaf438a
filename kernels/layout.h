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

// The normal equations of a metric's six unknowns, see system.h: 21 of the matrix's upper triangle, row by row, 6 of
// the right-hand side, the cost, and the trace of the information without a loss. They are added up in two rows of
// SUMS_PER_BLOCK, the rest of which is padding.
#define SYSTEM_SUMS 29
#define SYSTEM_SUMS_ROWS 2

// What a metric knows of a target point: a normal x y z, or the six xx xy xz yy yz zz of a symmetric 3x3 covariance,
// each with padding.
#define NORMAL_WORDS 4
#define COVARIANCE_WORDS 8
// Of a source point: a row for each of these.
#define NORMAL_ROWS 3
#define COVARIANCE_ROWS 6

// Losses, see loss.h.
#define LOSS_NONE 0
#define LOSS_HUBER 1
#define LOSS_CAUCHY 2
#define LOSS_GEMAN_MCCLURE 3
#define LOSS_TUKEY 4
#define LOSS_WELSCH 5

// The tree over the target (see tree.h): points of a leaf, children of a node, levels of nodes at most.
#define LEAF_POINTS 16
#define NODE_CHILDREN 16
#define TREE_LEVELS 8
// A leaf: LEAF_POINTS of x, of y, of z, and of the points' positions in the caller's cloud (int32). Unused: INFINITY,
// -1.
#define LEAF_WORDS 64
// A node: of its children's boxes the least x, y, z and the greatest x, y, z. Unused: INFINITY and -INFINITY.
#define NODE_WORDS 96

// Source points that a work-group matches.
#define POINTS_PER_MATCH_BLOCK 256
// Target points kept for each source point, nearest first, to be looked at before the tree.
#define KEPT_CANDIDATES 4
// Neighbours that the device finds for a query at most.
#define NEAREST_MOST 32

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

#ifdef __OPENCL_VERSION__
typedef struct {
  RigidSolution solution;
#else
template <typename real>
struct MatchSummary {
  RigidSolution<real> solution;
#endif
  real squared_distances; // sum over the matched points
  unsigned int matched;   // source points with a target point within the limit
  unsigned int searched;  // source points whose match had to be searched for
#ifdef __OPENCL_VERSION__
} MatchSummary;
#else
};
#endif

#endif
