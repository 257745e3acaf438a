// Stage 4: H = U S V^T. H^T H by 27 scalar products summed in threes; its eigenvectors are V; U = H V S^-1, so its
// signs follow V's. Squaring H costs half the digits: the columns of H V are orthogonalised once more, on H itself.
#include "svd3.h"

#pragma OPENCL FP_CONTRACT OFF

// Scalar product 9 i + 3 j + k: inner term k of entry (i, j) of G^T G.
static inline real gram_term(const real* G, uint product)
{
  const uint i = product / 9, j = product / 3 % 3, k = product % 3;
  return G[3 * k + i] * G[3 * k + j];
}

// H over its largest entry, so that H^T H neither overflows nor underflows.
static inline void scaled_copy(global const real* H, real* G)
{
  real scale = 0;
  for (int i = 0; i < 9; ++i)
    scale = fmax(scale, fabs(H[i]));
  for (int i = 0; i < 9; ++i)
    G[i] = scale > 0 ? H[i] / scale : 0;
}

static inline void decompose(const real* gram, uint n, real resolution_sq, global RigidSolution* solution)
{
  // A symmetric matrix's columns, orthogonalised from the right, leave its eigenvectors in V.
  real A[9], H[9], U[9], S[3], V[9];
  set_identity(V);
  for (int i = 0; i < 9; ++i) {
    A[i] = gram[i];
    H[i] = solution->H[i];
  }
  orthogonalise_columns(A, V);
  solution->rank = svd_from_right_vectors(H, n * resolution_sq, U, S, V);
  for (int i = 0; i < 9; ++i) {
    solution->U[i] = U[i];
    solution->V[i] = V[i];
  }
  for (int i = 0; i < 3; ++i)
    solution->S[i] = S[i];
}

#ifdef CHUNKED

// One work-item.
kernel void svd(uint n, float resolution_sq, global RigidSolution* solution)
{
  real G[9], gram[9];
  scaled_copy(solution->H, G);
  for (uint entry = 0; entry < 9; ++entry)
    gram[entry] = (gram_term(G, 3 * entry) + gram_term(G, 3 * entry + 1)) + gram_term(G, 3 * entry + 2);
  decompose(gram, n, resolution_sq, solution);
}

#else

// One work-group of 27 work-items.
kernel void svd(uint n, float resolution_sq, global RigidSolution* solution)
{
  local real terms[27];
  local real sums[9];
  const uint item = get_local_id(0);
  real G[9];
  scaled_copy(solution->H, G);
  terms[item] = gram_term(G, item);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (item < 9)
    sums[item] = (terms[3 * item] + terms[3 * item + 1]) + terms[3 * item + 2];
  barrier(CLK_LOCAL_MEM_FENCE);
  if (item == 0) {
    real gram[9];
    for (int i = 0; i < 9; ++i)
      gram[i] = sums[i];
    decompose(gram, n, resolution_sq, solution);
  }
}

#endif
