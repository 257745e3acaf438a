// Stage 2: p' = p - mu_p and q' = q - mu_q. Rows as in a buffer of pairs, kept in `real`; entries past n are zero.
#include "real.h"

static inline real centroid_of_row(global const RigidSolution* solution, uint row)
{
  return row < 3 ? solution->source_centroid[row] : solution->target_centroid[row - 3];
}

#ifdef CHUNKED

kernel void demean(global const float* restrict pairs,
                   uint stride,
                   uint n,
                   global const RigidSolution* solution,
                   global real* restrict demeaned)
{
  const uint begin = get_global_id(0) * POINTS_PER_BLOCK;
  const uint end = min(begin + POINTS_PER_BLOCK, stride);
  const uint row = get_global_id(1);
  const real mean = centroid_of_row(solution, row);
  for (uint i = begin; i < end; ++i)
    demeaned[row * stride + i] = i < n ? pairs[row * stride + i] - mean : 0;
}

#else

kernel void demean(global const float* restrict pairs,
                   uint stride,
                   uint n,
                   global const RigidSolution* solution,
                   global real* restrict demeaned)
{
  const uint i = get_global_id(0);
  const uint row = get_global_id(1);
  if (i < stride)
    demeaned[row * stride + i] = i < n ? pairs[row * stride + i] - centroid_of_row(solution, row) : 0;
}

#endif
