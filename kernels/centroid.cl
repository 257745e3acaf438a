// Stage 1: centroids of the source and target points. The coordinates are widened to `real` rows, then added
// pairwise, level by level, until one sum per row is left.
#include "pairwise_sum.h"

#ifdef CHUNKED

kernel void centroid_widen(global const float* restrict pairs, uint stride, global real* restrict rows)
{
  const uint begin = get_global_id(0) * POINTS_PER_BLOCK;
  const uint end = min(begin + POINTS_PER_BLOCK, stride);
  const uint row = get_global_id(1) * stride;
  for (uint i = begin; i < end; ++i)
    rows[row + i] = pairs[row + i];
}

#else

kernel void centroid_widen(global const float* restrict pairs, uint stride, global real* restrict rows)
{
  const uint i = get_global_id(0);
  if (i < stride)
    rows[get_global_id(1) * stride + i] = pairs[get_global_id(1) * stride + i];
}

#endif

// One work-item per row: sum / n.
kernel void centroid_mean(global const real* restrict sums, uint stride, uint n, global RigidSolution* solution)
{
  const uint row = get_global_id(0);
  const real mean = sums[row * stride] / n;
  if (row < 3)
    solution->source_centroid[row] = mean;
  else
    solution->target_centroid[row - 3] = mean;
}
