// The normal equations of a metric over the matched pairs. Of a pair, with p the source point at the pose, q its match,
// e = q - p, J = (-[p - c]x, I) what a small turn about c and a shift do to p (symmetric_factor.cl: to the middle of p
// and q), and M the pair's 3x3 information: the sums of J^T M J, of J^T M e and of s = e^T M e. With a loss M is
// weighed by rho'(s), and the sum of rho(s) is in the place of that of s.
//
// A metric is a file that includes this one and says what M is. It defines OWN_ROWS, how many values it knows of a pair
// beside the two points, of which the first is 1, or 0 where there is no pair; load_own(), which reads them; and
// add_equations(), which adds a pair to the sums and returns s. Then it includes system_pass.h.
#ifndef PCL_GPU_ICP_SYSTEM_H
#define PCL_GPU_ICP_SYSTEM_H

#include "solve.h"

#define KEPT_MOST KEPT_CANDIDATES
#include "match.h"
#include "tree.h"

#ifdef CHUNKED
#include "match_chunked.h"
typedef real_lanes lane;
#define PAIRS_AT_ONCE 16
#else
#include "match_grouped.h"
typedef real lane;
#define PAIRS_AT_ONCE 1
#endif

#pragma OPENCL FP_CONTRACT ON

#include "loss.h"

// Of p and q.
#define POINT_ROWS 6

// What a metric knows of the points, see layout.h.
typedef struct {
  global const float* target; // by position in the leaves
  global const float* source; // rows of `stride`
  uint stride;
} Own;

// A pair's share where M = n n^T; returns s. x: p - c
static inline lane add_plane(lane* sums, const lane* x, const lane* n, const lane* e, Loss loss)
{
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

// A pair's share where M is not of rank one; returns s. x: p - c; M: xx xy xz yy yz zz
static inline lane add_information(lane* sums, const lane* x, lane* M, const lane* e, Loss loss)
{
  lane Me[3] = {M[0] * e[0] + M[1] * e[1] + M[2] * e[2],
                M[1] * e[0] + M[3] * e[1] + M[4] * e[2],
                M[2] * e[0] + M[4] * e[1] + M[5] * e[2]};
  const lane squared = e[0] * Me[0] + e[1] * Me[1] + e[2] * Me[2];
  sums[SYSTEM_SUMS - 1] += M[0] + M[3] + M[5];
  if (loss.function != LOSS_NONE) {
    const lane weight = loss_weight(squared, loss);
    for (int i = 0; i < 6; ++i)
      M[i] *= weight;
    for (int i = 0; i < 3; ++i)
      Me[i] *= weight;
  }
  const lane rows[3][3] = {{M[0], M[1], M[2]}, {M[1], M[3], M[4]}, {M[2], M[4], M[5]}};
  lane crossed[3][3]; // [x]x M
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    for (int column = 0; column < 3; ++column)
      crossed[i][column] = x[j] * rows[k][column] - x[k] * rows[j][column];
  }
  int s = 0;
  for (int i = 0; i < 3; ++i) {
    // [x]x M [x]x^T, then the part that turn and shift share.
    for (int b = i; b < 3; ++b) {
      const int j = (b + 1) % 3, k = (b + 2) % 3;
      sums[s++] += x[j] * crossed[i][k] - x[k] * crossed[i][j];
    }
    for (int b = 0; b < 3; ++b)
      sums[s++] += crossed[i][b];
  }
  for (int i = 0; i < 3; ++i)
    for (int b = i; b < 3; ++b)
      sums[s++] += rows[i][b];
  for (int i = 0; i < 3; ++i)
    sums[s++] += x[(i + 1) % 3] * Me[(i + 2) % 3] - x[(i + 2) % 3] * Me[(i + 1) % 3];
  for (int i = 0; i < 3; ++i)
    sums[s++] += Me[i];
  sums[s] += loss.function != LOSS_NONE ? loss_cost(squared, loss) : squared;
  return squared;
}

#endif
