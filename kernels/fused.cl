// All five stages in two kernels: one pass over the pairs for all sums, then centroids, H, its SVD, R and t.
// H = sum p q^T - n mu_p mu_q^T; coordinates are about pivots near the centroids, so little cancels.
#include "svd3.h"

#pragma OPENCL FP_CONTRACT ON

#ifdef CHUNKED

// One work-item per block: pairs as in gather.cl, `partials` SUMS_PER_BLOCK values per block.
kernel void fused_sums(global const float* restrict pairs, uint stride, uint n, global real* restrict partials)
{
  const uint block = get_global_id(0);
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

// One work-group of WORK_GROUP_SIZE (a power of two) per block.
kernel void fused_sums(global const float* restrict pairs, uint stride, uint n, global real* restrict partials)
{
  local real scratch[WORK_GROUP_SIZE];
  const uint lane = get_local_id(0);
  const uint block = get_group_id(0);
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
  for (uint s = 0; s < SUMS_PER_BLOCK; ++s) {
    scratch[lane] = sums[s];
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint half_size = WORK_GROUP_SIZE / 2; half_size > 0; half_size /= 2) {
      if (lane < half_size)
        scratch[lane] += scratch[lane + half_size];
      barrier(CLK_LOCAL_MEM_FENCE);
    }
    if (lane == 0)
      partials[block * SUMS_PER_BLOCK + s] = scratch[0];
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}

#endif

// Contraction would undo the compensation below.
#pragma OPENCL FP_CONTRACT OFF

// Everything from the sums on; `sums` and what their additions lost (Neumaier 1974) are kept apart until here.
static inline void solve(const real* sums, const real* lost, uint n, real resolution_sq, global RigidSolution* solution)
{
  real mean[6], H[9], U[9], S[3], V[9];
  for (int i = 0; i < 6; ++i)
    mean[i] = (sums[i] + lost[i]) / n;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int k = 6 + 3 * i + j;
      H[3 * i + j] = (sums[k] - (real)n * mean[i] * mean[3 + j]) + lost[k];
    }

  set_identity(V);
  const int rank = svd_from_right_vectors(H, n * resolution_sq, U, S, V);

  const real sign = reflection_sign(U, V);
  real R[9];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      R[3 * i + j] = V[3 * i] * U[3 * j] + V[3 * i + 1] * U[3 * j + 1] + sign * V[3 * i + 2] * U[3 * j + 2];

  for (int i = 0; i < 3; ++i) {
    solution->source_centroid[i] = mean[i];
    solution->target_centroid[i] = mean[3 + i];
    solution->S[i] = S[i];
    solution->t[i] = mean[3 + i] - (R[3 * i] * mean[0] + R[3 * i + 1] * mean[1] + R[3 * i + 2] * mean[2]);
  }
  for (int i = 0; i < 9; ++i) {
    solution->H[i] = H[i];
    solution->U[i] = U[i];
    solution->V[i] = V[i];
    solution->R[i] = R[i];
  }
  solution->rank = rank;
}

#ifdef CHUNKED

// One work-item. resolution_sq: variance per pair below which a direction is only the coordinates' rounding.
kernel void fused_solve(
    global const real* restrict partials, uint blocks, uint n, float resolution_sq, global RigidSolution* solution)
{
  real_sums total = 0, lost = 0;
  for (uint block = 0; block < blocks; ++block) {
    const real_sums term = vload16(block, partials);
    const real_sums sum = total + term;
    lost += fabs(total) >= fabs(term) ? (total - sum) + term : (term - sum) + total;
    total = sum;
  }
  real sums[SUMS_PER_BLOCK], remainders[SUMS_PER_BLOCK];
  vstore16(total, 0, sums);
  vstore16(lost, 0, remainders);
  solve(sums, remainders, n, resolution_sq, solution);
}

#else

// One work-group of SUMS_PER_BLOCK work-items, each of which adds up one of the sums.
kernel void fused_solve(
    global const real* restrict partials, uint blocks, uint n, float resolution_sq, global RigidSolution* solution)
{
  local real totals[SUMS_PER_BLOCK], remainders[SUMS_PER_BLOCK];
  const uint s = get_local_id(0);
  real total = 0, lost = 0;
  for (uint block = 0; block < blocks; ++block) {
    const real term = partials[block * SUMS_PER_BLOCK + s];
    const real sum = total + term;
    lost += fabs(total) >= fabs(term) ? (total - sum) + term : (term - sum) + total;
    total = sum;
  }
  totals[s] = total;
  remainders[s] = lost;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (s == 0) {
    real sums[SUMS_PER_BLOCK], remainder[SUMS_PER_BLOCK];
    for (int i = 0; i < SUMS_PER_BLOCK; ++i) {
      sums[i] = totals[i];
      remainder[i] = remainders[i];
    }
    solve(sums, remainder, n, resolution_sq, solution);
  }
}

#endif
