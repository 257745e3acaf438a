// The sums over a work-group, for the grouped shape.
#ifndef PCL_GPU_ICP_GROUP_SUM_H
#define PCL_GPU_ICP_GROUP_SUM_H

#include "real.h"

// Of four values at once, because every step waits for the whole group. By all work-items of a group of
// WORK_GROUP_SIZE, a power of two; halving, so always in the same order. scratch: of as many values; sums: of four
static inline void sum_over_group(real4 values, local real4* scratch, global real* sums)
{
  const uint item = get_local_id(0);
  scratch[item] = values;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint half_size = WORK_GROUP_SIZE / 2; half_size > 0; half_size /= 2) {
    if (item < half_size)
      scratch[item] += scratch[item + half_size];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  if (item == 0)
    vstore4(scratch[0], 0, sums);
  barrier(CLK_LOCAL_MEM_FENCE);
}

#endif
