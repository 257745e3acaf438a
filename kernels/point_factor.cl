// Point-to-point (Besl and McKay 1992) as normal equations, for what the five stages' closed solution does not know:
// losses, and fewer than six motions. M = I.
#include "system.h"

// Whether there is a pair: 1, or 0.
#define OWN_ROWS 1

static inline void load_own(float (*rows)[PAIRS_AT_ONCE], const Own* own, uint i, const int* positions)
{
  for (int lane_number = 0; lane_number < PAIRS_AT_ONCE; ++lane_number)
    rows[0][lane_number] = positions[lane_number] >= 0;
}

static inline lane add_equations(lane* sums, const lane* x, const lane* e, const lane* row, float16 turn, Loss loss)
{
  lane M[6] = {row[0], 0, 0, row[0], 0, row[0]};
  return add_information(sums, x, M, e, loss);
}

#include "system_pass.h"
