// All five stages in two kernels: one pass over the pairs for all sums, then centroids, H, its SVD, R and t.
// H = sum p q^T - n mu_p mu_q^T; coordinates are about pivots near the centroids, so little cancels.
#include "block.h"
#include "solve.h"

#pragma OPENCL FP_CONTRACT ON

#ifdef CHUNKED

// One work-item per block: pairs as in gather.cl, `partials` SUMS_PER_BLOCK values per block.
kernel void listed_sums(global const float* restrict pairs, uint stride, uint n, global real* restrict partials)
{
  const uint block = get_block();
  const uint begin = block * POINTS_PER_BLOCK;
  const uint end = min(begin + POINTS_PER_BLOCK, stride);
  real_lanes p_x = 0, p_y = 0, p_z = 0, q_x = 0, q_y = 0, q_z = 0;
  real_lanes h_xx = 0, h_xy = 0, h_xz = 0, h_yx = 0, h_yy = 0, h_yz = 0, h_zx = 0, h_zy = 0, h_zz = 0;
  for (uint i = begin; i < end; i += LANES) {
    const real_lanes px = load_lanes(pairs + i);
    const real_lanes py = load_lanes(pairs + i + stride);
    const real_lanes pz = load_lanes(pairs + i + 2 * stride);
    const real_lanes qx = load_lanes(pairs + i + 3 * stride);
    const real_lanes qy = load_lanes(pairs + i + 4 * stride);
    const real_lanes qz = load_lanes(pairs + i + 5 * stride);
    p_x += px;
    p_y += py;
    p_z += pz;
    q_x += qx;
    q_y += qy;
    q_z += qz;
    h_xx += px * qx;
    h_xy += px * qy;
    h_xz += px * qz;
    h_yx += py * qx;
    h_yy += py * qy;
    h_yz += py * qz;
    h_zx += pz * qx;
    h_zy += pz * qy;
    h_zz += pz * qz;
  }
  global real* sums = partials + block * SUMS_PER_BLOCK;
  sums[0] = sum_lanes(p_x);
  sums[1] = sum_lanes(p_y);
  sums[2] = sum_lanes(p_z);
  sums[3] = sum_lanes(q_x);
  sums[4] = sum_lanes(q_y);
  sums[5] = sum_lanes(q_z);
  sums[6] = sum_lanes(h_xx);
  sums[7] = sum_lanes(h_xy);
  sums[8] = sum_lanes(h_xz);
  sums[9] = sum_lanes(h_yx);
  sums[10] = sum_lanes(h_yy);
  sums[11] = sum_lanes(h_yz);
  sums[12] = sum_lanes(h_zx);
  sums[13] = sum_lanes(h_zy);
  sums[14] = sum_lanes(h_zz);
  sums[15] = 0;
}

#else

#include "group_sum.h"

// One work-group of WORK_GROUP_SIZE (a power of two) per block.
kernel void listed_sums(global const float* restrict pairs, uint stride, uint n, global real* restrict partials)
{
  local real4 scratch[WORK_GROUP_SIZE];
  const uint lane = get_local_id(0);
  const uint block = get_block();
  real sums[SUMS_PER_BLOCK] = {0};
  for (uint step = 0; step < POINTS_PER_BLOCK; step += WORK_GROUP_SIZE) {
    const uint i = block * POINTS_PER_BLOCK + step + lane;
    if (i >= n)
      continue;
    const real p[3] = {pairs[i], pairs[i + stride], pairs[i + 2 * stride]};
    const real q[3] = {pairs[i + 3 * stride], pairs[i + 4 * stride], pairs[i + 5 * stride]};
    for (int a = 0; a < 3; ++a) {
      sums[a] += p[a];
      sums[3 + a] += q[a];
      for (int b = 0; b < 3; ++b)
        sums[6 + 3 * a + b] += p[a] * q[b];
    }
  }
#pragma unroll
  for (uint s = 0; s < SUMS_PER_BLOCK; s += 4)
    sum_over_group(
        (real4)(sums[s], sums[s + 1], sums[s + 2], sums[s + 3]), scratch, partials + block * SUMS_PER_BLOCK + s);
}

#endif

// One work-group of SUMS_PER_BLOCK work-items, or one work-item.
// resolution_sq: variance per pair below which a direction is only the coordinates' rounding.
kernel void listed_solve(
    global const real* restrict partials, uint blocks, uint n, float resolution_sq, global RigidSolution* solution)
{
  SUMS_SPACE real sums[SUMS_PER_BLOCK], lost[SUMS_PER_BLOCK];
  add_partials(partials, blocks, sums, lost);
  if (get_local_id(0) == 0)
    solve(sums, lost, n, resolution_sq, solution);
}
