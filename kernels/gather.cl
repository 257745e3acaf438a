// Matched pairs from two clouds that stay on the device: pair k is (pose(source[i_k]), target[j_k]).
#include "real.h"

#pragma OPENCL FP_CONTRACT ON

// source, target: rows x, y, z of source_stride and target_stride floats, about their pivots
// matches: n pairs of indices (source, target)
// pose: 12 of 16 floats, rows of [R | t], from the source's frame to the target's
// pairs: PAIR_ROWS rows of `stride` floats; entries past n are set to zero
static inline void gather_pair(uint k,
                               global const float* restrict source,
                               uint source_stride,
                               global const float* restrict target,
                               uint target_stride,
                               global const int2* restrict matches,
                               uint n,
                               float16 pose,
                               global float* restrict pairs,
                               uint stride)
{
  float3 p = (float3)(0.0f), q = (float3)(0.0f);
  if (k < n) {
    const int2 match = matches[k];
    const float x = source[match.x];
    const float y = source[match.x + source_stride];
    const float z = source[match.x + 2 * source_stride];
    p = (float3)(pose.s0 * x + pose.s1 * y + pose.s2 * z + pose.s3,
                 pose.s4 * x + pose.s5 * y + pose.s6 * z + pose.s7,
                 pose.s8 * x + pose.s9 * y + pose.sa * z + pose.sb);
    q = (float3)(target[match.y], target[match.y + target_stride], target[match.y + 2 * target_stride]);
  }
  pairs[k] = p.x;
  pairs[k + stride] = p.y;
  pairs[k + 2 * stride] = p.z;
  pairs[k + 3 * stride] = q.x;
  pairs[k + 4 * stride] = q.y;
  pairs[k + 5 * stride] = q.z;
}

// A work-item for each chunk of pairs, or for each pair.
kernel void gather(global const float* restrict source,
                   uint source_stride,
                   global const float* restrict target,
                   uint target_stride,
                   global const int2* restrict matches,
                   uint n,
                   float16 pose,
                   global float* restrict pairs,
                   uint stride)
{
#ifdef CHUNKED
  const uint pairs_each = POINTS_PER_BLOCK;
#else
  const uint pairs_each = 1;
#endif
  const uint begin = get_global_id(0) * pairs_each;
  const uint end = min(begin + pairs_each, stride);
  for (uint k = begin; k < end; ++k)
    gather_pair(k, source, source_stride, target, target_stride, matches, n, pose, pairs, stride);
}
