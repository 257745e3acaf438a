// Correspondences: for every source point at the current pose the nearest target point within the limit, and in the
// same pass the sums of the five stages over the pairs.
//
// A source point is searched for only when its match can have changed. A search keeps the nearest few target points and
// the distance within which there is nothing else, its reach. Once the source point has moved by m, everything else is
// farther than reach - m: a kept point nearer than that is still the nearest (and with none that near, a limit below
// that still excludes all). The nearest one has a reach of its own, to the next, so that often it alone is looked at.
#include "solve.h"

#define KEPT_MOST KEPT_CANDIDATES
#include "match.h"
#include "tree.h"

#ifdef CHUNKED
#include "match_chunked.h"
#else
#include "match_grouped.h"
#endif

#define SOURCE_ARGUMENTS                                                                                               \
  global const float *source_points, global float *searched_at, global int *candidates, global int *matches,           \
      uint stride, uint n, float16 pose
#define SOURCE                                                                                                         \
  {                                                                                                                    \
    source_points, searched_at, candidates, matches, stride, n                                                         \
  }

// Where the device searches: everything in one pass.
// partials, tallies: per block SUMS_PER_BLOCK sums, the last of squared distances, and how many points are matched and
// how many were searched for
kernel void match(SOURCE_ARGUMENTS,
                  global const float* restrict leaves,
                  global const float* restrict nodes,
                  uint8 first_node,
                  uint root_level,
                  float limit_sq,
                  float slack,
                  uint kept,
                  uint tested,
                  global real* restrict partials,
                  global uint2* restrict tallies)
{
  const Source source = SOURCE;
  const Tree tree = tree_of(leaves, nodes, first_node, root_level);
  const Effort effort = {limit_sq, slack, kept, tested};
  const uint searched = match_block(&source, pose, &tree, &effort);
#ifdef CHUNKED
  const uint matched = accumulate_block(&source, pose, leaves, partials);
  tallies[get_block()] = (uint2)(matched, searched);
#else
  local real4 scratch[WORK_GROUP_SIZE];
  local uint tally[2];
  const Total total = accumulate_block(&source, pose, leaves);
  write_total(&total, searched, scratch, tally, partials, tallies);
#endif
}

// Where the host searches: first, the points to search for.
// queries: the first entry starts with their number (uint, 0 before); then x, y, z and the squared distance to search
// within queried: the source points they are of
kernel void certify(SOURCE_ARGUMENTS,
                    global const float* restrict leaves,
                    float limit_sq,
                    float slack,
                    uint tested,
                    global float4* queries,
                    global uint* restrict queried)
{
  const Source source = SOURCE;
  const Effort effort = {limit_sq, slack, KEPT_CANDIDATES, tested};
  certify_block(&source, pose, leaves, &effort, queries, queried);
}

// Then, what the host found for n_queries queries from the first on: a work-item per query, or per chunk of queries.
// answers: rows of n_queries words: KEPT_CANDIDATES of positions (int) and two of reaches (float), of the nearest and
// of all queries: their number is 0 after
kernel void adopt(global float* searched_at,
                  global int* candidates,
                  global int* matches,
                  uint stride,
                  global float4* queries,
                  global const uint* restrict queried,
                  global const int* restrict answers,
                  uint first,
                  uint n_queries)
{
#ifdef CHUNKED
  const uint queries_each = POINTS_PER_BLOCK;
#else
  const uint queries_each = 1;
#endif
  const uint begin = get_global_id(0) * queries_each;
  const uint end = min(begin + queries_each, n_queries);
  for (uint j = begin; j < end; ++j) {
    const uint i = queried[first + j];
    const float4 query = queries[1 + first + j];
    searched_at[i] = query.x;
    searched_at[i + stride] = query.y;
    searched_at[i + 2 * stride] = query.z;
    for (uint row = 0; row < 2; ++row)
      searched_at[i + (3 + row) * stride] = as_float(answers[j + (KEPT_CANDIDATES + row) * n_queries]);
    for (uint k = 0; k < KEPT_CANDIDATES; ++k)
      candidates[i + k * stride] = answers[j + k * n_queries];
    matches[i] = answers[j];
  }
  if (get_global_id(0) == 0)
    *(global uint*)queries = 0;
}

// Last, the sums over the matches, which may be those of another pose.
kernel void accumulate(SOURCE_ARGUMENTS,
                       global const float* restrict leaves,
                       global real* restrict partials,
                       global uint2* restrict tallies)
{
  const Source source = SOURCE;
#ifdef CHUNKED
  tallies[get_block()] = (uint2)(accumulate_block(&source, pose, leaves, partials), 0);
#else
  local real4 scratch[WORK_GROUP_SIZE];
  local uint tally[2];
  const Total total = accumulate_block(&source, pose, leaves);
  write_total(&total, 0, scratch, tally, partials, tallies);
#endif
}

// One work-group of SUMS_PER_BLOCK work-items, or one work-item.
kernel void match_solve(global const real* restrict partials,
                        global const uint2* restrict tallies,
                        uint blocks,
                        float resolution_sq,
                        global MatchSummary* summary)
{
  SUMS_SPACE real sums[SUMS_PER_BLOCK], lost[SUMS_PER_BLOCK];
  add_partials(partials, blocks, sums, lost);
  uint2 tally = 0;
  for (uint block = get_local_id(0); block < blocks; block += get_local_size(0))
    tally += tallies[block];
#ifndef CHUNKED
  local uint2 counts[SUMS_PER_BLOCK];
  counts[get_local_id(0)] = tally;
  barrier(CLK_LOCAL_MEM_FENCE);
  tally = 0;
  for (uint item = 0; item < SUMS_PER_BLOCK; ++item)
    tally += counts[item];
#endif
  if (get_local_id(0) != 0)
    return;
  summary->matched = tally.x;
  summary->searched = tally.y;
  summary->squared_distances = sums[15] + lost[15];
  if (tally.x > 0)
    solve(sums, lost, tally.x, resolution_sq, &summary->solution);
}
