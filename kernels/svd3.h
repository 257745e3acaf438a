// Singular value decomposition of a 3x3 matrix by one-sided Jacobi rotations (Hestenes 1958; Drmac and Veselic 2008
// for its accuracy), with defined answers for every rank, and the rotation of Kabsch (1976) and Umeyama (1991).
#ifndef PCL_GPU_ICP_SVD3_H
#define PCL_GPU_ICP_SVD3_H

#include "real.h"

// Quadratic convergence: three to five sweeps are usual; the bound is for matrices of non-finite values.
#define MAX_SWEEPS 16

// Rotates columns i and j of the row-major 3x3 matrix m by (c, s).
static inline void rotate_columns(real* m, int i, int j, real c, real s)
{
  for (int row = 0; row < 9; row += 3) {
    const real a = m[row + i], b = m[row + j];
    m[row + i] = c * a - s * b;
    m[row + j] = s * a + c * b;
  }
}

// Makes the columns of B = H V orthogonal by rotations from the right, which V collects.
static inline void orthogonalise_columns(real* B, real* V)
{
  for (int sweep = 0; sweep < MAX_SWEEPS; ++sweep) {
    int rotations = 0;
    for (int pair = 0; pair < 3; ++pair) {
      const int i = pair == 2 ? 1 : 0, j = pair == 0 ? 1 : 2;
      const real alpha = B[i] * B[i] + B[i + 3] * B[i + 3] + B[i + 6] * B[i + 6];
      const real beta = B[j] * B[j] + B[j + 3] * B[j + 3] + B[j + 6] * B[j + 6];
      const real gamma = B[i] * B[j] + B[i + 3] * B[j + 3] + B[i + 6] * B[j + 6];
      if (!(fabs(gamma) > REAL_EPSILON * sqrt(alpha) * sqrt(beta)))
        continue;
      ++rotations;
      const real zeta = (beta - alpha) / (2 * gamma);
      const real tangent = copysign((real)1, zeta) / (fabs(zeta) + sqrt(1 + zeta * zeta));
      const real cosine = 1 / sqrt(1 + tangent * tangent);
      rotate_columns(B, i, j, cosine, cosine * tangent);
      rotate_columns(V, i, j, cosine, cosine * tangent);
    }
    if (rotations == 0)
      break;
  }
}

static inline real column_norm(const real* m, int i)
{
  return sqrt(m[i] * m[i] + m[i + 3] * m[i + 3] + m[i + 6] * m[i + 6]);
}

static inline void swap_columns(real* m, int i, int j)
{
  for (int row = 0; row < 9; row += 3) {
    const real held = m[row + i];
    m[row + i] = m[row + j];
    m[row + j] = held;
  }
}

// Column 2 of m becomes column 0 x column 1.
static inline void complete_with_cross_product(real* m)
{
  m[2] = m[3] * m[7] - m[6] * m[4];
  m[5] = m[6] * m[1] - m[0] * m[7];
  m[8] = m[0] * m[4] - m[3] * m[1];
}

static inline real determinant(const real* m)
{
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
}

static inline void set_identity(real* m)
{
  for (int i = 0; i < 9; ++i)
    m[i] = i % 4 == 0 ? 1 : 0;
}

// Column 1 of U becomes a unit vector across column 0, column 1 of V its image under the smallest rotation that takes
// column 0 of U to column 0 of V: what a line leaves open is left as it was.
static inline void complete_line(real* U, real* V)
{
  const real u[3] = {U[0], U[3], U[6]};
  const real v[3] = {V[0], V[3], V[6]};
  const int least = fabs(u[0]) <= fabs(u[1]) ? (fabs(u[0]) <= fabs(u[2]) ? 0 : 2) : (fabs(u[1]) <= fabs(u[2]) ? 1 : 2);
  // w = (e_least - u_least u) / |...|
  real w[3] = {-u[least] * u[0], -u[least] * u[1], -u[least] * u[2]};
  w[least] += 1;
  const real length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  for (int i = 0; i < 3; ++i)
    U[3 * i + 1] = w[i] /= length;
  // Rodrigues about a = u x v, with |a| = sin and u.v = cos; no turn and half a turn leave w where it is.
  const real a[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const real cosine = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  const real aw = a[0] * w[0] + a[1] * w[1] + a[2] * w[2];
  const real sine_sq = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
  const bool turns = sine_sq > REAL_EPSILON * REAL_EPSILON;
  const real cross[3] = {a[1] * w[2] - a[2] * w[1], a[2] * w[0] - a[0] * w[2], a[0] * w[1] - a[1] * w[0]};
  const real k = cosine > 0 ? 1 / (1 + cosine) : (turns ? (1 - cosine) / sine_sq : 0);
  real image[3];
  for (int i = 0; i < 3; ++i)
    image[i] = turns ? cosine * w[i] + cross[i] + k * aw * a[i] : w[i];
  // Against rounding close to half a turn: exactly across v, exactly of length 1.
  const real along = image[0] * v[0] + image[1] * v[1] + image[2] * v[2];
  for (int i = 0; i < 3; ++i)
    image[i] -= along * v[i];
  const real image_length = sqrt(image[0] * image[0] + image[1] * image[1] + image[2] * image[2]);
  for (int i = 0; i < 3; ++i)
    V[3 * i + 1] = image[i] / image_length;
}

// Completes H = U S V^T from a first V (the identity, or eigenvectors of H^T H). Singular values of at most `noise`
// count as zero. Returns the rank.
static inline int svd_from_right_vectors(const real* H, real noise, real* U, real* S, real* V)
{
  real scale = 0;
  for (int i = 0; i < 9; ++i)
    scale = fmax(scale, fabs(H[i]));
  if (!(scale > noise)) {
    set_identity(U);
    set_identity(V);
    S[0] = S[1] = S[2] = 0;
    return 0;
  }

  real B[9];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      B[3 * i + j] = H[3 * i] / scale * V[j] + H[3 * i + 1] / scale * V[j + 3] + H[3 * i + 2] / scale * V[j + 6];
  orthogonalise_columns(B, V);

  for (int pass = 0; pass < 3; ++pass) {
    const int i = pass == 1 ? 1 : 0;
    if (column_norm(B, i) < column_norm(B, i + 1)) {
      swap_columns(B, i, i + 1);
      swap_columns(V, i, i + 1);
    }
  }
  for (int i = 0; i < 3; ++i)
    S[i] = column_norm(B, i);

  const real zero = fmax(noise / scale, 4 * REAL_EPSILON * S[0]);
  const int rank = S[1] <= zero ? 1 : S[2] <= zero ? 2 : 3;
  for (int row = 0; row < 9; row += 3)
    U[row] = B[row] / S[0];
  if (rank == 1) {
    complete_line(U, V);
    complete_with_cross_product(V);
    S[1] = S[2] = 0;
  }
  else {
    // Across column 0 to the last digit, also where S[1] is small against S[0].
    const real along = U[0] * B[1] + U[3] * B[4] + U[6] * B[7];
    const real b[3] = {B[1] - along * U[0], B[4] - along * U[3], B[7] - along * U[6]};
    const real length = sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
    for (int i = 0; i < 3; ++i)
      U[3 * i + 1] = b[i] / length;
  }
  complete_with_cross_product(U);
  if (U[2] * B[2] + U[5] * B[5] + U[8] * B[8] < 0)
    for (int row = 2; row < 9; row += 3)
      U[row] = -U[row];
  for (int i = 0; i < 3; ++i)
    S[i] *= scale;
  return rank;
}

// +1 or -1: what the smallest singular direction is multiplied by so that V diag(1, 1, sign) U^T is a rotation.
static inline real reflection_sign(const real* U, const real* V)
{
  return determinant(V) * determinant(U) < 0 ? -1 : 1;
}

#endif
