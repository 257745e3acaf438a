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
  const lane* n = row + 1;
  const lane J[6] = {x[1] * n[2] - x[2] * n[1], x[2] * n[0] - x[0] * n[2], x[0] * n[1] - x[1] * n[0], n[0], n[1], n[2]};
  const lane r = n[0] * e[0] + n[1] * e[1] + n[2] * e[2];
  const lane squared = r * r;
  sums[SYSTEM_SUMS - 1] += n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  lane weighed[6] = {J[0], J[1], J[2], J[3], J[4], J[5]};
  if (loss.function != LOSS_NONE) {
    const lane weight = loss_weight(squared, loss);
    for (int a = 0; a < 6; ++a)
      weighed[a] *= weight;
  }
  int s = 0;
  for (int a = 0; a < 6; ++a)
    for (int b = a; b < 6; ++b)
      sums[s++] += weighed[a] * J[b];
  for (int a = 0; a < 6; ++a)
    sums[s++] += weighed[a] * r;
  sums[s] += loss.function != LOSS_NONE ? loss_cost(squared, loss) : squared;
  return squared;
}

#include "system_pass.h"
