// From the sums over all pairs to the rigid transform: centroids, H = sum p q^T - n mu_p mu_q^T, its SVD, R and t.
// Coordinates are about pivots near the centroids, so little cancels.
#ifndef PCL_GPU_ICP_SOLVE_H
#define PCL_GPU_ICP_SOLVE_H

#include "svd3.h"

// Where the sums are added up.
#ifdef CHUNKED
#define SUMS_SPACE private
#else
#define SUMS_SPACE local
#endif

// Contraction would undo the compensation below.
#pragma OPENCL FP_CONTRACT OFF

// Everything from the sums on; `sums` and what their additions lost (Neumaier 1974) are kept apart until here.
static inline void solve(SUMS_SPACE const real* sums,
                         SUMS_SPACE const real* lost,
                         uint n,
                         real resolution_sq,
                         global RigidSolution* solution)
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

// One work-item adds up the partial sums of all blocks, SUMS_PER_BLOCK values each.
static inline void add_partials(global const real* restrict partials, uint blocks, real* sums, real* lost)
{
  real_sums total = 0, remainder = 0;
  for (uint block = 0; block < blocks; ++block) {
    const real_sums term = vload16(block, partials);
    const real_sums sum = total + term;
    remainder += fabs(total) >= fabs(term) ? (total - sum) + term : (term - sum) + total;
    total = sum;
  }
  vstore16(total, 0, sums);
  vstore16(remainder, 0, lost);
}

#else

#define BLOCKS_AT_ONCE 8

// A work-group of SUMS_PER_BLOCK work-items, each of which adds up one of the sums; all get all of them. The terms of a
// few blocks are read at once, because a sum alone would wait for the memory in each step.
static inline void add_partials(global const real* restrict partials, uint blocks, local real* sums, local real* lost)
{
  const uint s = get_local_id(0);
  real total = 0, remainder = 0;
  for (uint first = 0; first < blocks; first += BLOCKS_AT_ONCE) {
    real terms[BLOCKS_AT_ONCE];
#pragma unroll
    for (uint i = 0; i < BLOCKS_AT_ONCE; ++i)
      terms[i] = partials[min(first + i, blocks - 1) * SUMS_PER_BLOCK + s];
#pragma unroll
    for (uint i = 0; i < BLOCKS_AT_ONCE; ++i)
      if (first + i < blocks) {
        const real sum = total + terms[i];
        remainder += fabs(total) >= fabs(terms[i]) ? (total - sum) + terms[i] : (terms[i] - sum) + total;
        total = sum;
      }
  }
  sums[s] = total;
  lost[s] = remainder;
  barrier(CLK_LOCAL_MEM_FENCE);
}

#endif

#endif
