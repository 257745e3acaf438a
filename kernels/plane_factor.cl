// Point-to-plane (Chen and Medioni 1992), linearised (Low 2004): M = n n^T, with n the normal at the target point.
// Where n is zero a pair counts for nothing.
#include "system.h"

// Whether there is a pair (1, or 0), and n.
#define OWN_ROWS 4

static inline void load_own(float (*rows)[PAIRS_AT_ONCE], const Own* own, uint i, const int* positions)
{
  for (int lane_number = 0; lane_number < PAIRS_AT_ONCE; ++lane_number) {
    const int position = positions[lane_number];
    for (int r = 0; r < 3; ++r)
      rows[1 + r][lane_number] = position < 0 ? 0 : own->target[position * NORMAL_WORDS + r];
    rows[0][lane_number] = rows[1][lane_number] != 0 || rows[2][lane_number] != 0 || rows[3][lane_number] != 0;
  }
}

static inline lane add_equations(lane* sums, const lane* x, const lane* e, const lane* row, float16 turn, Loss loss)
{
  return add_plane(sums, x, row + 1, e, loss);
}

#include "system_pass.h"
