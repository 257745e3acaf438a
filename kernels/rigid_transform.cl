// Stage 5: R = V diag(1, 1, det(V U^T)) U^T by 27 scalar products summed in threes, t = mu_q - R mu_p.
#include "svd3.h"

#pragma OPENCL FP_CONTRACT OFF

// Scalar product 9 i + 3 j + k: inner term k of entry (i, j) of R.
static inline real rotation_term(global const RigidSolution* solution, real sign, uint product)
{
  const uint i = product / 9, j = product / 3 % 3, k = product % 3;
  return (k == 2 ? sign : 1) * solution->V[3 * i + k] * solution->U[3 * j + k];
}

static inline real sign_of(global const RigidSolution* solution)
{
  real U[9], V[9];
  for (int i = 0; i < 9; ++i) {
    U[i] = solution->U[i];
    V[i] = solution->V[i];
  }
  return reflection_sign(U, V);
}

static inline real translation(global const RigidSolution* solution, const real* R_row, uint i)
{
  return solution->target_centroid[i] -
         (R_row[0] * solution->source_centroid[0] + R_row[1] * solution->source_centroid[1] +
          R_row[2] * solution->source_centroid[2]);
}

#ifdef CHUNKED

// One work-item.
kernel void rigid_transform(global RigidSolution* solution)
{
  const real sign = sign_of(solution);
  for (uint i = 0; i < 3; ++i) {
    real row[3];
    for (uint j = 0; j < 3; ++j) {
      const uint product = 9 * i + 3 * j;
      row[j] = (rotation_term(solution, sign, product) + rotation_term(solution, sign, product + 1)) +
               rotation_term(solution, sign, product + 2);
      solution->R[3 * i + j] = row[j];
    }
    solution->t[i] = translation(solution, row, i);
  }
}

#else

// One work-group of 27 work-items.
kernel void rigid_transform(global RigidSolution* solution)
{
  local real terms[27];
  local real R[9];
  const uint item = get_local_id(0);
  terms[item] = rotation_term(solution, sign_of(solution), item);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (item < 9) {
    R[item] = (terms[3 * item] + terms[3 * item + 1]) + terms[3 * item + 2];
    solution->R[item] = R[item];
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  if (item < 3) {
    const real row[3] = {R[3 * item], R[3 * item + 1], R[3 * item + 2]};
    solution->t[item] = translation(solution, row, item);
  }
}

#endif
