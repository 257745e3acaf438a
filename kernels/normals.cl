// Surface normals: at every query the direction in which the covariance of its nearest points is least (Hoppe et al.
// 1992).
#include "svd3.h"

#define KEPT_MOST NEAREST_MOST
#include "tree.h"

#pragma OPENCL FP_CONTRACT ON

// A unit vector; NaN where the points do not span a plane.
// positions: of the nearest points, k rows of `stride` entries; -1: no more
static inline float3 normal_at(float3 query,
                               global const float* restrict leaves,
                               global const int* restrict positions,
                               uint stride,
                               uint k,
                               float resolution_sq)
{
  real first[3] = {0}, second[9] = {0};
  uint count = 0;
  for (uint row = 0; row < k; ++row) {
    const int position = positions[row * stride];
    if (position < 0)
      break;
    const float3 offset = leaf_point(leaves, position) - query;
    const real d[3] = {offset.x, offset.y, offset.z};
    for (int i = 0; i < 3; ++i) {
      first[i] += d[i];
      for (int j = 0; j < 3; ++j)
        second[3 * i + j] += d[i] * d[j];
    }
    ++count;
  }
  real A[9], V[9];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      A[3 * i + j] = (second[3 * i + j] - first[i] * first[j] / count);
  const real trace = A[0] + A[4] + A[8];
  for (int i = 0; i < 9; ++i)
    A[i] /= trace;
  // A symmetric matrix's columns, orthogonalised from the right, leave its eigenvectors in V.
  set_identity(V);
  orthogonalise_columns(A, V);
  const real norms[3] = {column_norm(A, 0), column_norm(A, 1), column_norm(A, 2)};
  const int least = norms[0] <= norms[1] ? (norms[0] <= norms[2] ? 0 : 2) : (norms[1] <= norms[2] ? 1 : 2);
  const real middle = fmin(norms[(least + 1) % 3], norms[(least + 2) % 3]);
  // Also where all is zero or too large, and therefore NaN.
  if (!(middle > fmax(16 * REAL_EPSILON, count * resolution_sq / trace)))
    return (float3)(NAN);
  return (float3)(V[least], V[3 + least], V[6 + least]);
}

// queries, stride, n, leaves: as in nearest.cl; positions: what it found
// resolution_sq: variance below which a direction is only the coordinates' rounding
// normals: rows x, y, z of `stride` floats
// A work-item per block of POINTS_PER_MATCH_BLOCK queries, or per query.
kernel void normals(global const float* restrict queries,
                    uint stride,
                    uint n,
                    global const float* restrict leaves,
                    global const int* restrict positions,
                    uint k,
                    float resolution_sq,
                    global float* restrict normals)
{
#ifdef CHUNKED
  const uint queries_each = POINTS_PER_MATCH_BLOCK;
#else
  const uint queries_each = 1;
#endif
  const uint begin = get_global_id(0) * queries_each;
  const uint end = min(begin + queries_each, n);
  for (uint i = begin; i < end; ++i) {
    const float3 query = (float3)(queries[i], queries[i + stride], queries[i + 2 * stride]);
    const float3 normal = normal_at(query, leaves, positions + i, stride, k, resolution_sq);
    normals[i] = normal.x;
    normals[i + stride] = normal.y;
    normals[i + 2 * stride] = normal.z;
  }
}
