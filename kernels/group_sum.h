// The sum over a work-group, for the grouped shape.
#ifndef PCL_GPU_ICP_GROUP_SUM_H
#define PCL_GPU_ICP_GROUP_SUM_H

#include "real.h"

// By all work-items of a group of WORK_GROUP_SIZE, a power of two; halving, so always in the same order. scratch: of as
// many values
static inline void sum_over_group(real value, local real* scratch, global real* sum)
{
  const uint item = get_local_id(0);
  scratch[item] = value;
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint half_size = WORK_GROUP_SIZE / 2; half_size > 0; half_size /= 2) {
    if (item < half_size)
      scratch[item] += scratch[item + half_size];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
  if (item == 0)
    *sum = scratch[0];
  barrier(CLK_LOCAL_MEM_FENCE);
}

#endif
