// The k nearest points of a tree for every query, nearest first.
#define KEPT_MOST NEAREST_MOST
#include "block.h"
#include "tree.h"
#ifdef CHUNKED
#include "keep_chunked.h"
#endif

// queries: rows x, y, z of `stride` floats, the first n of them queries, close ones next to each other
// k: at most NEAREST_MOST
// positions, distances_sq: k rows of `stride` entries; -1 and INFINITY where there are fewer points
// A work-item per block of POINTS_PER_MATCH_BLOCK queries, sixteen at a time; or a work-item per query.
kernel void nearest(global const float* restrict queries,
                    uint stride,
                    uint n,
                    global const float* restrict leaves,
                    global const float* restrict nodes,
                    uint8 first_node,
                    uint root_level,
                    uint k,
                    global int* restrict positions,
                    global float* restrict distances_sq)
{
  const Tree tree = tree_of(leaves, nodes, first_node, root_level);
#ifdef CHUNKED
  const uint begin = get_block() * POINTS_PER_MATCH_BLOCK;
  const uint end = min(begin + POINTS_PER_MATCH_BLOCK, n);
  for (uint i = begin; i < end; i += 16) {
    const Points q = {vload16(0, queries + i), vload16(0, queries + i + stride), vload16(0, queries + i + 2 * stride)};
    const int16 there = LANE_NUMBERS < (int16)(n - i);
    Search search = search_of(q, select((float16)(-1), (float16)(INFINITY), there), INFINITY, k);
    search_tree(&search, &tree);
    for (uint row = 0; row < k; ++row) {
      vstore16(search.positions[row], 0, positions + i + row * stride);
      vstore16(search.distances_sq[row], 0, distances_sq + i + row * stride);
    }
  }
#else
  const uint i = get_global_id(0);
  if (i >= n)
    return;
  Search search = search_of((float3)(queries[i], queries[i + stride], queries[i + 2 * stride]), INFINITY, INFINITY, k);
  search_tree(&search, &tree);
#pragma unroll
  for (uint place = 0; place < KEPT_MOST; ++place) {
    const uint row = rank_of(&search, place);
    if (row < k) {
      positions[i + row * stride] = search.positions[place];
      distances_sq[i + row * stride] = search.distances_sq[place];
    }
  }
#endif
}
