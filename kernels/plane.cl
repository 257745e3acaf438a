// Point-to-plane (Chen and Medioni 1992), linearised (Low 2004): over the matched pairs the sums of the least-squares
// problem J x = r for the small rotation vector and the translation x, with J = ((p - c) x n, n) and r = n . (q - p).
// p: source point at the pose, q: its match, n: the normal there, c: about which it turns. Where n is zero a pair
// counts for nothing.
#include "solve.h"

#define KEPT_MOST KEPT_CANDIDATES
#include "match.h"
#include "tree.h"

#ifdef CHUNKED
#include "match_chunked.h"
#else
#include "match_grouped.h"
#endif

#pragma OPENCL FP_CONTRACT ON

// source_points, stride, n, pose, matches: as in match.cl; from the last source point to the stride matches are -1
// normals: in leaves as the target's points are
// partials: PLANE_SUMS_ROWS rows of SUMS_PER_BLOCK sums for each block

#ifdef CHUNKED

static inline void add_planes(real_lanes* sums, Points p, Points q, Points n, int16 matched, float4 centre)
{
  float rows[9][16];
  vstore16(select((float16)(0), p.x, matched), 0, rows[0]);
  vstore16(select((float16)(0), p.y, matched), 0, rows[1]);
  vstore16(select((float16)(0), p.z, matched), 0, rows[2]);
  vstore16(select((float16)(0), q.x, matched), 0, rows[3]);
  vstore16(select((float16)(0), q.y, matched), 0, rows[4]);
  vstore16(select((float16)(0), q.z, matched), 0, rows[5]);
  vstore16(select((float16)(0), n.x, matched), 0, rows[6]);
  vstore16(select((float16)(0), n.y, matched), 0, rows[7]);
  vstore16(select((float16)(0), n.z, matched), 0, rows[8]);
  for (int part = 0; part < 16; part += LANES) {
    real_lanes row[9];
    for (int r = 0; r < 9; ++r)
      row[r] = load_lanes(rows[r] + part);
    const real_lanes x = row[0] - (real)centre.x, y = row[1] - (real)centre.y, z = row[2] - (real)centre.z;
    const real_lanes J[6] = {
        y * row[8] - z * row[7], z * row[6] - x * row[8], x * row[7] - y * row[6], row[6], row[7], row[8]};
    const real_lanes r = row[6] * (row[3] - row[0]) + row[7] * (row[4] - row[1]) + row[8] * (row[5] - row[2]);
    int s = 0;
    for (int a = 0; a < 6; ++a)
      for (int b = a; b < 6; ++b)
        sums[s++] += J[a] * J[b];
    for (int a = 0; a < 6; ++a)
      sums[s++] += J[a] * r;
    sums[s] += r * r;
  }
}

// One work-item per block of POINTS_PER_MATCH_BLOCK source points.
kernel void plane_sums(global const float* source_points,
                       global int* matches,
                       uint stride,
                       uint n,
                       float16 pose,
                       global const float* restrict leaves,
                       global const float* restrict normals,
                       float4 centre,
                       uint blocks,
                       global real* restrict partials)
{
  const Source source = {source_points, 0, 0, matches, stride, n};
  const uint block = get_block();
  const uint begin = block * POINTS_PER_MATCH_BLOCK;
  const uint end = min(begin + POINTS_PER_MATCH_BLOCK, n);
  real_lanes sums[PLANE_SUMS];
  for (int s = 0; s < PLANE_SUMS; ++s)
    sums[s] = 0;
  for (uint i = begin; i < end; i += 16) {
    const int16 match = vload16(0, matches + i);
    add_planes(sums, moved(&source, i, pose), gathered(leaves, match), gathered(normals, match), match >= 0, centre);
  }
  for (int s = 0; s < PLANE_SUMS_ROWS * SUMS_PER_BLOCK; ++s)
    partials[(s / SUMS_PER_BLOCK * blocks + block) * SUMS_PER_BLOCK + s % SUMS_PER_BLOCK] =
        s < PLANE_SUMS ? sum_lanes(sums[s]) : 0;
}

#else

static inline void add_plane(real* sums, float3 p, float3 q, float3 n, float4 centre)
{
  const real P[3] = {p.x, p.y, p.z}, Q[3] = {q.x, q.y, q.z}, N[3] = {n.x, n.y, n.z};
  const real x = P[0] - centre.x, y = P[1] - centre.y, z = P[2] - centre.z;
  const real J[6] = {y * N[2] - z * N[1], z * N[0] - x * N[2], x * N[1] - y * N[0], N[0], N[1], N[2]};
  const real r = N[0] * (Q[0] - P[0]) + N[1] * (Q[1] - P[1]) + N[2] * (Q[2] - P[2]);
  int s = 0;
  for (int a = 0; a < 6; ++a)
    for (int b = a; b < 6; ++b)
      sums[s++] += J[a] * J[b];
  for (int a = 0; a < 6; ++a)
    sums[s++] += J[a] * r;
  sums[s] += r * r;
}

// One work-group of WORK_GROUP_SIZE (a power of two) per block of POINTS_PER_MATCH_BLOCK source points.
kernel void plane_sums(global const float* source_points,
                       global int* matches,
                       uint stride,
                       uint n,
                       float16 pose,
                       global const float* restrict leaves,
                       global const float* restrict normals,
                       float4 centre,
                       uint blocks,
                       global real* restrict partials)
{
  const Source source = {source_points, 0, 0, matches, stride, n};
  local real scratch[WORK_GROUP_SIZE];
  const uint item = get_local_id(0);
  const uint block = get_block();
  const uint begin = block * POINTS_PER_MATCH_BLOCK;
  const uint end = min(begin + POINTS_PER_MATCH_BLOCK, n);
  real sums[PLANE_SUMS_ROWS * SUMS_PER_BLOCK] = {0};
  for (uint i = begin + item; i < end; i += WORK_GROUP_SIZE) {
    const int match = matches[i];
    if (match >= 0)
      add_plane(sums, moved(&source, i, pose), leaf_point(leaves, match), leaf_point(normals, match), centre);
  }
  for (int s = 0; s < PLANE_SUMS_ROWS * SUMS_PER_BLOCK; ++s) {
    scratch[item] = sums[s];
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint half_size = WORK_GROUP_SIZE / 2; half_size > 0; half_size /= 2) {
      if (item < half_size)
        scratch[item] += scratch[item + half_size];
      barrier(CLK_LOCAL_MEM_FENCE);
    }
    if (item == 0)
      partials[(s / SUMS_PER_BLOCK * blocks + block) * SUMS_PER_BLOCK + s % SUMS_PER_BLOCK] = scratch[0];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}

#endif

// One work-group of SUMS_PER_BLOCK work-items, or one work-item. total: PLANE_SUMS values
kernel void plane_total(global const real* restrict partials, uint blocks, global real* restrict total)
{
  SUMS_SPACE real sums[PLANE_SUMS_ROWS * SUMS_PER_BLOCK], lost[PLANE_SUMS_ROWS * SUMS_PER_BLOCK];
  for (int row = 0; row < PLANE_SUMS_ROWS; ++row)
    add_partials(
        partials + row * blocks * SUMS_PER_BLOCK, blocks, sums + row * SUMS_PER_BLOCK, lost + row * SUMS_PER_BLOCK);
  if (get_local_id(0) == 0)
    for (int s = 0; s < PLANE_SUMS; ++s)
      total[s] = sums[s] + lost[s];
}
