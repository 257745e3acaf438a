// Point-to-plane (Chen and Medioni 1992), linearised (Low 2004): M = n n^T, with n the normal at the target point.
// Where n is zero a pair counts for nothing.
#include "system.h"

#define OWN_ROWS 3

static inline void load_own(float (*rows)[PAIRS_AT_ONCE], const Own* own, uint i, const int* positions)
{
  for (int r = 0; r < OWN_ROWS; ++r)
    for (int lane_number = 0; lane_number < PAIRS_AT_ONCE; ++lane_number) {
      const int position = positions[lane_number];
      rows[r][lane_number] = position < 0 ? 0 : own->target[position * NORMAL_WORDS + r];
    }
}

static inline void add_equations(lane* sums, const lane* x, const lane* e, const lane* n, float16 turn)
{
  const lane J[6] = {x[1] * n[2] - x[2] * n[1], x[2] * n[0] - x[0] * n[2], x[0] * n[1] - x[1] * n[0], n[0], n[1], n[2]};
  const lane r = n[0] * e[0] + n[1] * e[1] + n[2] * e[2];
  int s = 0;
  for (int a = 0; a < 6; ++a)
    for (int b = a; b < 6; ++b)
      sums[s++] += J[a] * J[b];
  for (int a = 0; a < 6; ++a)
    sums[s++] += J[a] * r;
  sums[s] += r * r;
}

#include "system_pass.h"
