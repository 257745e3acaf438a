// Stage 3: H = sum p' q'^T. Each pair's outer product (9 rows), then pairwise sums.
#include "pairwise_sum.h"

// Entry (a, b) of H is row 3 a + b.
static inline real outer_product(global const real* restrict demeaned, uint stride, uint row, uint i)
{
  return demeaned[row / 3 * stride + i] * demeaned[(3 + row % 3) * stride + i];
}

#ifdef CHUNKED

kernel void outer_products(global const real* restrict demeaned, uint stride, global real* restrict products)
{
  const uint begin = get_global_id(0) * POINTS_PER_BLOCK;
  const uint end = min(begin + POINTS_PER_BLOCK, stride);
  const uint row = get_global_id(1);
  for (uint i = begin; i < end; ++i)
    products[row * stride + i] = outer_product(demeaned, stride, row, i);
}

#else

kernel void outer_products(global const real* restrict demeaned, uint stride, global real* restrict products)
{
  const uint i = get_global_id(0);
  const uint row = get_global_id(1);
  if (i < stride)
    products[row * stride + i] = outer_product(demeaned, stride, row, i);
}

#endif

// One work-item per row.
kernel void store_covariance(global const real* restrict sums, uint stride, global RigidSolution* solution)
{
  const uint row = get_global_id(0);
  solution->H[row] = sums[row * stride];
}
