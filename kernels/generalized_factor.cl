// Generalized ICP (Segal, Haehnel and Thrun 2009): M = (C_q + R C_p R^T)^-1, with C_p and C_q the covariances of the
// two points and R the rotation that the pairs were matched at.
#include "system.h"

#define OWN_ROWS (1 + 2 * COVARIANCE_ROWS)

// Whether there is a pair (1, or 0), C_q and C_p: xx xy xz yy yz zz. Where there is none M must exist as well.
static inline void load_own(float (*rows)[PAIRS_AT_ONCE], const Own* own, uint i, const int* positions)
{
  const float identity[COVARIANCE_ROWS] = {1, 0, 0, 1, 0, 1};
  for (int lane_number = 0; lane_number < PAIRS_AT_ONCE; ++lane_number) {
    const int position = positions[lane_number];
    rows[0][lane_number] = position < 0 ? 0 : 1;
    for (int r = 0; r < COVARIANCE_ROWS; ++r) {
      rows[1 + r][lane_number] = position < 0 ? identity[r] : own->target[position * COVARIANCE_WORDS + r];
      rows[1 + COVARIANCE_ROWS + r][lane_number] = position < 0 ? 0 : own->source[i + lane_number + r * own->stride];
    }
  }
}

static inline lane add_equations(lane* sums, const lane* x, const lane* e, const lane* row, float16 turn, Loss loss)
{
  const lane* Q = row + 1;
  const lane* P = Q + COVARIANCE_ROWS;
  const real R[3][3] = {{turn.s0, turn.s1, turn.s2}, {turn.s4, turn.s5, turn.s6}, {turn.s8, turn.s9, turn.sa}};
  const lane C_p[3][3] = {{P[0], P[1], P[2]}, {P[1], P[3], P[4]}, {P[2], P[4], P[5]}};
  lane turned[3][3]; // R C_p
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      turned[i][j] = R[i][0] * C_p[0][j] + R[i][1] * C_p[1][j] + R[i][2] * C_p[2][j];
  lane C[COVARIANCE_ROWS];
  int s = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j, ++s)
      C[s] = Q[s] + (turned[i][0] * R[j][0] + turned[i][1] * R[j][1] + turned[i][2] * R[j][2]);

  lane M[COVARIANCE_ROWS] = {C[3] * C[5] - C[4] * C[4],
                             C[2] * C[4] - C[1] * C[5],
                             C[1] * C[4] - C[2] * C[3],
                             C[0] * C[5] - C[2] * C[2],
                             C[1] * C[2] - C[0] * C[4],
                             C[0] * C[3] - C[1] * C[1]};
  const lane scale = row[0] / (C[0] * M[0] + C[1] * M[1] + C[2] * M[2]);
  for (int entry = 0; entry < COVARIANCE_ROWS; ++entry)
    M[entry] *= scale;
  return add_information(sums, x, M, e, loss);
}

#include "system_pass.h"
