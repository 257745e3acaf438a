// The symmetric objective (Rusinkiewicz 2019), linearised: M = n n^T, with n the mean of the two points' normals, of
// which one is turned about where they point away from each other, and the lever that of the points' middle. Where a
// normal is zero a pair counts for nothing.
#include "system.h"

// Whether there is a pair (1, or 0), n_q and n_p.
#define OWN_ROWS 7

static inline void load_own(float (*rows)[PAIRS_AT_ONCE], const Own* own, uint i, const int* positions)
{
  for (int lane_number = 0; lane_number < PAIRS_AT_ONCE; ++lane_number) {
    const int position = positions[lane_number];
    bool exist = position >= 0;
    for (int first = 1; first < OWN_ROWS; first += NORMAL_ROWS) {
      bool is_zero = true;
      for (int r = 0; r < NORMAL_ROWS; ++r) {
        const float value = position < 0 ? 0
                            : first == 1 ? own->target[position * NORMAL_WORDS + r]
                                         : own->source[i + lane_number + r * own->stride];
        rows[first + r][lane_number] = value;
        is_zero = is_zero && value == 0;
      }
      exist = exist && !is_zero;
    }
    rows[0][lane_number] = exist;
  }
}

static inline lane add_equations(lane* sums, const lane* x, const lane* e, const lane* row, float16 turn, Loss loss)
{
  const lane* n_q = row + 1;
  const lane* p = n_q + NORMAL_ROWS;
  const real R[3][3] = {{turn.s0, turn.s1, turn.s2}, {turn.s4, turn.s5, turn.s6}, {turn.s8, turn.s9, turn.sa}};
  lane n_p[3];
  for (int i = 0; i < 3; ++i)
    n_p[i] = R[i][0] * p[0] + R[i][1] * p[1] + R[i][2] * p[2];
  const lane cosine = n_q[0] * n_p[0] + n_q[1] * n_p[1] + n_q[2] * n_p[2];
  const lane half_q = row[0] / 2;
  const lane half_p = cosine < 0 ? -half_q : half_q;
  lane n[3], middle[3];
  for (int i = 0; i < 3; ++i) {
    n[i] = half_q * n_q[i] + half_p * n_p[i];
    middle[i] = x[i] + e[i] / 2;
  }
  return add_plane(sums, middle, n, e, loss);
}

#include "system_pass.h"
