// One level of the pairwise reduction: m values in each row become ceil(m / 2), neighbour added to neighbour.
#ifndef PCL_GPU_ICP_PAIRWISE_SUM_H
#define PCL_GPU_ICP_PAIRWISE_SUM_H

#include "real.h"

#pragma OPENCL FP_CONTRACT OFF

#ifdef CHUNKED

// Work-item (c, row) writes results [c, c + 1) * POINTS_PER_BLOCK of that row.
kernel void pairwise_sum(global const real* restrict values, uint stride, uint m, global real* restrict sums)
{
  const uint results = (m + 1) / 2;
  const uint begin = get_global_id(0) * POINTS_PER_BLOCK;
  const uint end = min(begin + POINTS_PER_BLOCK, results);
  values += get_global_id(1) * stride;
  sums += get_global_id(1) * stride;
  uint i = begin;
  for (; i + 8 <= end && 2 * i + 16 <= m; i += 8) {
    const real8 v = vload8(0, values + 2 * i), w = vload8(1, values + 2 * i);
    vstore4(v.even + v.odd, 0, sums + i);
    vstore4(w.even + w.odd, 1, sums + i);
  }
  for (; i < end; ++i)
    sums[i] = 2 * i + 1 < m ? values[2 * i] + values[2 * i + 1] : values[2 * i];
}

#else

// Work-item (i, row) adds values 2i and 2i + 1 of that row.
kernel void pairwise_sum(global const real* restrict values, uint stride, uint m, global real* restrict sums)
{
  const uint i = get_global_id(0);
  if (i >= (m + 1) / 2)
    return;
  values += get_global_id(1) * stride;
  sums += get_global_id(1) * stride;
  sums[i] = 2 * i + 1 < m ? values[2 * i] + values[2 * i + 1] : values[2 * i];
}

#endif

#endif
