// Surface normals: at every query the direction in which the covariance of its nearest points is least (Hoppe et al.
// 1992): a unit vector, or NaN where the points do not span a plane.
#include "nearest.cl"
#include "svd3.h"

#pragma OPENCL FP_CONTRACT ON

// queries, stride, n, leaves: as in nearest.cl; positions: what it found, k rows of `stride` entries; -1: no more
// resolution_sq: variance below which a direction is only the coordinates' rounding
// normals: rows x, y, z of `stride` floats

#ifdef CHUNKED

// Quadratic convergence: the fourth sweep finds nothing left to turn but for rounding.
#define SWEEPS 6

// A symmetric matrix in each lane, and the rotation that diagonalises it.
typedef struct {
  real_lanes entries[3][3]; // of which those on and above the diagonal are in use
  real_lanes vectors[3][3]; // columns
} Decomposition;

// Jacobi's rotation of rows and columns i < j; k is the third.
static inline void rotate_lanes(Decomposition* e, int i, int j, int k)
{
  const real_lanes off = e->entries[i][j];
  const real_lanes zeta = (e->entries[j][j] - e->entries[i][i]) / (2 * off);
  const real_lanes turn = copysign((real_lanes)(1), zeta) / (fabs(zeta) + sqrt(1 + zeta * zeta));
  const real_lanes tangent = off == 0 ? (real_lanes)(0) : turn;
  const real_lanes cosine = 1 / sqrt(1 + tangent * tangent), sine = cosine * tangent;
  e->entries[i][i] -= tangent * off;
  e->entries[j][j] += tangent * off;
  e->entries[i][j] = 0;
  real_lanes* ik = k < i ? &e->entries[k][i] : &e->entries[i][k];
  real_lanes* jk = k < j ? &e->entries[k][j] : &e->entries[j][k];
  const real_lanes held = *ik;
  *ik = cosine * held - sine * *jk;
  *jk = sine * held + cosine * *jk;
  for (int row = 0; row < 3; ++row) {
    const real_lanes a = e->vectors[row][i], b = e->vectors[row][j];
    e->vectors[row][i] = cosine * a - sine * b;
    e->vectors[row][j] = sine * a + cosine * b;
  }
}

// What the neighbours of LANES queries sum up to, their coordinates about the query's.
typedef struct {
  real_lanes first[3], second[3][3];
  real_lanes count;
} Moments;

static inline Moments moments_of(global const float* restrict queries,
                                 uint stride,
                                 global const float* restrict leaves,
                                 global const int* restrict positions,
                                 uint k)
{
  Moments m;
  m.count = 0;
  for (int a = 0; a < 3; ++a) {
    m.first[a] = 0;
    for (int b = 0; b < 3; ++b)
      m.second[a][b] = 0;
  }
  for (uint row = 0; row < k; ++row) {
    float offset[3][LANES], there[LANES];
    for (int lane = 0; lane < LANES; ++lane) {
      const int position = positions[row * stride + lane];
      there[lane] = position < 0 ? 0 : 1;
      global const float* p = leaves + max(position, 0) / LEAF_POINTS * LEAF_WORDS + max(position, 0) % LEAF_POINTS;
      for (int axis = 0; axis < 3; ++axis)
        offset[axis][lane] = position < 0 ? 0 : p[axis * LEAF_POINTS] - queries[axis * stride + lane];
    }
    m.count += load_lanes(there);
    real_lanes d[3];
    for (int axis = 0; axis < 3; ++axis)
      d[axis] = load_lanes(offset[axis]);
    for (int a = 0; a < 3; ++a) {
      m.first[a] += d[a];
      for (int b = a; b < 3; ++b)
        m.second[a][b] += d[a] * d[b];
    }
  }
  return m;
}

// A work-item per block of POINTS_PER_MATCH_BLOCK queries, LANES of them at a time.
kernel void normals(global const float* restrict queries,
                    uint stride,
                    uint n,
                    global const float* restrict leaves,
                    global const int* restrict positions,
                    uint k,
                    float resolution_sq,
                    global float* restrict normals)
{
  const uint begin = get_block() * POINTS_PER_MATCH_BLOCK;
  const uint end = min(begin + POINTS_PER_MATCH_BLOCK, n);
  for (uint i = begin; i < end; i += LANES) {
    const Moments m = moments_of(queries + i, stride, leaves, positions + i, k);
    Decomposition e;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        e.entries[a][b] = m.second[a][b] - m.first[a] * m.first[b] / m.count;
        e.vectors[a][b] = a == b ? 1 : 0;
      }
    const real_lanes trace = e.entries[0][0] + e.entries[1][1] + e.entries[2][2];
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b)
        e.entries[a][b] /= trace;
    for (int sweep = 0; sweep < SWEEPS; ++sweep) {
      rotate_lanes(&e, 0, 1, 2);
      rotate_lanes(&e, 0, 2, 1);
      rotate_lanes(&e, 1, 2, 0);
    }
    const real_lanes x = e.entries[0][0], y = e.entries[1][1], z = e.entries[2][2];
    const real_lanes least = fmin(x, fmin(y, z));
    const real_lanes middle = fmax(fmin(x, y), fmin(fmax(x, y), z));
    const real_lanes noise = fmax((real_lanes)(16 * REAL_EPSILON), m.count * resolution_sq / trace);
    for (int row = 0; row < 3; ++row) {
      const real_lanes along = x == least ? e.vectors[row][0] : y == least ? e.vectors[row][1] : e.vectors[row][2];
      // Also where all is zero or too large, and therefore NaN.
      store_lanes(middle > noise ? along : (real_lanes)(NAN), normals + i + row * stride);
    }
  }
}

#else

// A work-item per query.
kernel void normals(global const float* restrict queries,
                    uint stride,
                    uint n,
                    global const float* restrict leaves,
                    global const int* restrict positions,
                    uint k,
                    float resolution_sq,
                    global float* restrict normals)
{
  const uint i = get_global_id(0);
  if (i >= n)
    return;
  const float3 query = (float3)(queries[i], queries[i + stride], queries[i + 2 * stride]);
  real first[3] = {0}, second[9] = {0};
  uint count = 0;
  for (uint row = 0; row < k; ++row) {
    const int position = positions[i + row * stride];
    if (position < 0)
      break;
    const float3 offset = leaf_point(leaves, position) - query;
    const real d[3] = {offset.x, offset.y, offset.z};
    for (int a = 0; a < 3; ++a) {
      first[a] += d[a];
      for (int b = 0; b < 3; ++b)
        second[3 * a + b] += d[a] * d[b];
    }
    ++count;
  }
  real A[9], V[9];
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      A[3 * a + b] = second[3 * a + b] - first[a] * first[b] / count;
  const real trace = A[0] + A[4] + A[8];
  for (int entry = 0; entry < 9; ++entry)
    A[entry] /= trace;
  // A symmetric matrix's columns, orthogonalised from the right, leave its eigenvectors in V.
  set_identity(V);
  orthogonalise_columns(A, V);
  const real norms[3] = {column_norm(A, 0), column_norm(A, 1), column_norm(A, 2)};
  const int least = norms[0] <= norms[1] ? (norms[0] <= norms[2] ? 0 : 2) : (norms[1] <= norms[2] ? 1 : 2);
  const real middle = fmin(norms[(least + 1) % 3], norms[(least + 2) % 3]);
  // Also where all is zero or too large, and therefore NaN.
  const bool spans_plane = middle > fmax(16 * REAL_EPSILON, count * resolution_sq / trace);
  for (int row = 0; row < 3; ++row)
    normals[i + row * stride] = spans_plane ? V[3 * row + least] : NAN;
}

#endif
