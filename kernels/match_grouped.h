// Matching for GPUs: a source point per work-item, a work-group per block of them. Included by match.cl, which says
// how.
#ifndef PCL_GPU_ICP_MATCH_GROUPED_H
#define PCL_GPU_ICP_MATCH_GROUPED_H

#include "group_sum.h"

#pragma OPENCL FP_CONTRACT ON

// pose: 12 of 16 floats, rows of [R | t], from the source's frame to the target's
static inline float3 moved(const Source* source, uint i, float16 pose)
{
  const float x = source->points[i], y = source->points[i + source->stride], z = source->points[i + 2 * source->stride];
  return (float3)(pose.s0 * x + pose.s1 * y + pose.s2 * z + pose.s3,
                  pose.s4 * x + pose.s5 * y + pose.s6 * z + pose.s7,
                  pose.s8 * x + pose.s9 * y + pose.sa * z + pose.sb);
}

// As in the tree's search, to the bit: a match is the same whether it was searched for or kept.
static inline float squared_distance(float3 a, float3 b)
{
#pragma OPENCL FP_CONTRACT OFF
  const float x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
  return x * x + y * y + z * z;
}

// What a work-item has added up.
typedef struct {
  real sums[SUMS_PER_BLOCK];
  uint matched;
} Total;

static inline void add_pair(Total* total, float3 p, float3 q, float distance_sq)
{
  const real P[3] = {p.x, p.y, p.z}, Q[3] = {q.x, q.y, q.z};
  for (int a = 0; a < 3; ++a) {
    total->sums[a] += P[a];
    total->sums[3 + a] += Q[a];
    for (int b = 0; b < 3; ++b)
      total->sums[6 + 3 * a + b] += P[a] * Q[b];
  }
  total->sums[15] += distance_sq;
  ++total->matched;
}

// Adds up what the work-items of a group have, in a fixed order. By all of them.
static inline void write_total(const Total* total,
                               uint searched,
                               local real4* scratch,
                               local uint* tally,
                               global real* restrict partials,
                               global uint2* restrict tallies)
{
  const uint item = get_local_id(0);
  const real* sums = total->sums;
#pragma unroll
  for (int s = 0; s < SUMS_PER_BLOCK; s += 4)
    sum_over_group(
        (real4)(sums[s], sums[s + 1], sums[s + 2], sums[s + 3]), scratch, partials + get_block() * SUMS_PER_BLOCK + s);
  if (item == 0)
    tally[0] = tally[1] = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  atomic_add(&tally[0], total->matched);
  atomic_add(&tally[1], searched);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (item == 0)
    tallies[get_block()] = (uint2)(tally[0], tally[1]);
}

// What the kept candidates say of a point.
typedef struct {
  float3 at;        // at the pose
  float nearest_sq; // to the nearest candidate; INFINITY: there is none
  int nearest;
  bool uncertain; // something else may be nearer
} Candidates;

static inline Candidates look_at_candidates(
    const Source* source, uint i, float16 pose, global const float* restrict leaves, const Effort* effort)
{
  Candidates found = {moved(source, i, pose), INFINITY, -1, false};
  if (!isfinite(found.at.x + found.at.y + found.at.z))
    return found;
  found.uncertain = true;
  if (effort->tested == 0)
    return found;
  const float3 from = (float3)(source->searched_at[i],
                               source->searched_at[i + source->stride],
                               source->searched_at[i + 2 * source->stride]);
  const float moved_by = sqrt(squared_distance(found.at, from));
  for (uint k = 0; k < effort->tested && found.uncertain; ++k) {
    const int candidate = source->candidates[i + k * source->stride];
    const float distance_sq = squared_distance(leaf_point(leaves, max(candidate, 0)), found.at);
    if (candidate >= 0 && distance_sq < found.nearest_sq) {
      found.nearest_sq = distance_sq;
      found.nearest = candidate;
    }
    if (k > 0 && k < effort->tested - 1)
      continue;
    const float reach = source->searched_at[i + (k == 0 ? 3 : 4) * source->stride];
    found.uncertain = !((sqrt(min(found.nearest_sq, effort->limit_sq)) + moved_by) * CERTAINTY < reach);
  }
  return found;
}

// The squared distance to search within: a little farther than the nearest candidate, so that it is found again.
static inline float start_of(float nearest_sq, const Effort* effort)
{
  const float start = (sqrt(nearest_sq) + effort->slack) * CERTAINTY + 1e-18f;
  return min(effort->limit_sq, start * start);
}

// Searches for source point i; returns the squared distance of its nearest target point, INFINITY: none.
// nearest_sq: the nearest candidate's distance
static inline float search_match(
    const Source* source, uint i, const Tree* tree, float3 query, float nearest_sq, const Effort* effort, int* match)
{
  Search search = search_of(query, start_of(nearest_sq, effort), effort->slack, effort->kept);
  search_tree(&search, tree);
  source->searched_at[i] = query.x;
  source->searched_at[i + source->stride] = query.y;
  source->searched_at[i + 2 * source->stride] = query.z;
  // Of what is so far that its square is infinite nothing is known.
  const float bound_sq = min(search.bound_sq, MAXFLOAT);
  source->searched_at[i + 3 * source->stride] = sqrt(min(search.second_sq, bound_sq));
  source->searched_at[i + 4 * source->stride] = sqrt(bound_sq);
#pragma unroll
  for (uint k = 0; k < KEPT_CANDIDATES; ++k)
    source->candidates[i + rank_of(&search, k) * source->stride] = search.positions[k];
  *match = search.nearest;
  return search.nearest_sq;
}

// A work-group per block of POINTS_PER_MATCH_BLOCK source points; so are the others.
static inline Total accumulate_block(const Source* source, float16 pose, global const float* restrict leaves)
{
  const uint begin = get_block() * POINTS_PER_MATCH_BLOCK;
  const uint end = min(begin + POINTS_PER_MATCH_BLOCK, source->n);
  Total total = {{0}, 0};
  for (uint i = begin + get_local_id(0); i < end; i += WORK_GROUP_SIZE) {
    const int match = source->matches[i];
    if (match < 0)
      continue;
    const float3 p = moved(source, i, pose), q = leaf_point(leaves, match);
    add_pair(&total, p, q, squared_distance(p, q));
  }
  return total;
}

// Returns how many points this work-item had to search for.
static inline uint match_block(const Source* source, float16 pose, const Tree* tree, const Effort* effort)
{
  const uint begin = get_block() * POINTS_PER_MATCH_BLOCK;
  const uint end = min(begin + POINTS_PER_MATCH_BLOCK, source->n);
  uint searched = 0;
  for (uint i = begin + get_local_id(0); i < end; i += WORK_GROUP_SIZE) {
    Candidates found = look_at_candidates(source, i, pose, tree->leaves, effort);
    if (found.uncertain) {
      found.nearest_sq = search_match(source, i, tree, found.at, found.nearest_sq, effort, &found.nearest);
      ++searched;
    }
    source->matches[i] = found.nearest_sq < effort->limit_sq ? found.nearest : -1;
  }
  return searched;
}

static inline void certify_block(const Source* source,
                                 float16 pose,
                                 global const float* restrict leaves,
                                 const Effort* effort,
                                 global float4* queries,
                                 global uint* restrict queried)
{
  const uint begin = get_block() * POINTS_PER_MATCH_BLOCK;
  const uint end = min(begin + POINTS_PER_MATCH_BLOCK, source->n);
  for (uint i = begin + get_local_id(0); i < end; i += WORK_GROUP_SIZE) {
    const Candidates found = look_at_candidates(source, i, pose, leaves, effort);
    source->matches[i] = found.nearest_sq < effort->limit_sq ? found.nearest : -1;
    if (!found.uncertain)
      continue;
    const uint j = atomic_inc((volatile global uint*)queries);
    queries[1 + j] = (float4)(found.at, start_of(found.nearest_sq, effort));
    queried[j] = i;
  }
}

#endif
