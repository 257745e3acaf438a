// Matching for CPUs: sixteen source points at a time, a work-item per block of them. Included by match.cl, which says
// how.
#ifndef PCL_GPU_ICP_MATCH_CHUNKED_H
#define PCL_GPU_ICP_MATCH_CHUNKED_H

#include "keep_chunked.h"
#pragma OPENCL FP_CONTRACT ON

// pose: 12 of 16 floats, rows of [R | t], from the source's frame to the target's
static inline Points moved(const Source* source, uint i, float16 pose)
{
  const float16 x = vload16(0, source->points + i);
  const float16 y = vload16(0, source->points + i + source->stride);
  const float16 z = vload16(0, source->points + i + 2 * source->stride);
  const Points p = {pose.s0 * x + pose.s1 * y + pose.s2 * z + pose.s3,
                    pose.s4 * x + pose.s5 * y + pose.s6 * z + pose.s7,
                    pose.s8 * x + pose.s9 * y + pose.sa * z + pose.sb};
  return p;
}

static inline Points gathered(global const float* restrict leaves, int16 positions)
{
  int position[16];
  // Not max(positions, 0): oclgrind 21.10 gets that wrong.
  vstore16(select(positions, (int16)(0), positions < 0), 0, position);
  float x[16], y[16], z[16];
  for (int lane = 0; lane < 16; ++lane) {
    global const float* p = leaves + position[lane] / LEAF_POINTS * LEAF_WORDS + position[lane] % LEAF_POINTS;
    x[lane] = p[0];
    y[lane] = p[LEAF_POINTS];
    z[lane] = p[2 * LEAF_POINTS];
  }
  const Points points = {vload16(0, x), vload16(0, y), vload16(0, z)};
  return points;
}

// As in the tree's search, to the bit: a match is the same whether it was searched for or kept.
static inline float16 squared_distance(Points a, Points b)
{
#pragma OPENCL FP_CONTRACT OFF
  const float16 x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
  return x * x + y * y + z * z;
}

// 16 pairs as rows x, y, z of p and of q; those that are not `matched` are zero.
static inline void store_pairs(Points p, Points q, int16 matched, float (*rows)[16])
{
  vstore16(select((float16)(0), p.x, matched), 0, rows[0]);
  vstore16(select((float16)(0), p.y, matched), 0, rows[1]);
  vstore16(select((float16)(0), p.z, matched), 0, rows[2]);
  vstore16(select((float16)(0), q.x, matched), 0, rows[3]);
  vstore16(select((float16)(0), q.y, matched), 0, rows[4]);
  vstore16(select((float16)(0), q.z, matched), 0, rows[5]);
}

// Adds 16 pairs to the sums; those that are not `matched` count as zero.
static inline void add_pairs(real_lanes* sums, Points p, Points q, float16 distances_sq, int16 matched)
{
  float rows[PAIR_ROWS + 1][16];
  store_pairs(p, q, matched, rows);
  vstore16(select((float16)(0), distances_sq, matched), 0, rows[6]);
  for (int part = 0; part < 16; part += LANES) {
    real_lanes row[PAIR_ROWS + 1];
    for (int r = 0; r < PAIR_ROWS + 1; ++r)
      row[r] = load_lanes(rows[r] + part);
    for (int a = 0; a < 6; ++a)
      sums[a] += row[a];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        sums[6 + 3 * a + b] += row[a] * row[3 + b];
    sums[15] += row[6];
  }
}

// Lane by lane, as sum_lanes.
static inline uint count_of(int16 v)
{
  return -(v.s0 + v.s1 + v.s2 + v.s3 + v.s4 + v.s5 + v.s6 + v.s7 + v.s8 + v.s9 + v.sa + v.sb + v.sc + v.sd + v.se +
           v.sf);
}

// What the kept candidates say of points [i, i + 16).
typedef struct {
  Points at;          // at the pose
  int16 there;        // is a point, and finite
  float16 nearest_sq; // to the nearest candidate; INFINITY: there is none
  int16 nearest;
  int16 uncertain; // there, but something else may be nearer
} Candidates;

static inline void
look_at_candidate(const Source* source, uint i, uint k, global const float* restrict leaves, Candidates* found)
{
  const int16 kept = vload16(0, source->candidates + i + k * source->stride);
  const int16 candidate = select((int16)(-1), kept, found->there);
  const float16 distance_sq = squared_distance(gathered(leaves, candidate), found->at);
  const int16 nearer = candidate >= 0 && distance_sq < found->nearest_sq;
  found->nearest_sq = select(found->nearest_sq, distance_sq, nearer);
  found->nearest = select(found->nearest, candidate, nearer);
}

static inline int16 may_have_changed(const Candidates* found, float16 moved_by, float16 reach, float limit_sq)
{
  const float16 needed = sqrt(min(found->nearest_sq, limit_sq)) + moved_by;
  return found->uncertain && !(needed * CERTAINTY < reach);
}

static inline Candidates look_at_candidates(
    const Source* source, uint i, float16 pose, global const float* restrict leaves, const Effort* effort)
{
  Candidates found;
  found.at = moved(source, i, pose);
  found.there = LANE_NUMBERS < (int16)(source->n - i) && isfinite(found.at.x + found.at.y + found.at.z);
  found.nearest_sq = INFINITY;
  found.nearest = -1;
  found.uncertain = found.there;
  if (effort->tested > 0) {
    const Points from = {vload16(0, source->searched_at + i),
                         vload16(0, source->searched_at + i + source->stride),
                         vload16(0, source->searched_at + i + 2 * source->stride)};
    const float16 moved_by = sqrt(squared_distance(found.at, from));
    look_at_candidate(source, i, 0, leaves, &found);
    found.uncertain =
        may_have_changed(&found, moved_by, vload16(0, source->searched_at + i + 3 * source->stride), effort->limit_sq);
    if (effort->tested > 1 && any_of(found.uncertain)) {
      for (uint k = 1; k < KEPT_CANDIDATES; ++k)
        look_at_candidate(source, i, k, leaves, &found);
      found.uncertain = may_have_changed(
          &found, moved_by, vload16(0, source->searched_at + i + 4 * source->stride), effort->limit_sq);
    }
  }
  return found;
}

// The squared distances to search within: a little farther than the nearest candidate, so that it is found again.
static inline float16 start_of(float16 nearest_sq, const Effort* effort)
{
  const float16 start = (sqrt(nearest_sq) + effort->slack) * CERTAINTY + 1e-18f;
  return min(effort->limit_sq, start * start);
}

static inline void
search_uncertain(const Source* source, uint i, const Tree* tree, const Effort* effort, Candidates* found)
{
  const int16 searched = found->uncertain;
  const float16 radius_sq = select((float16)(-1), start_of(found->nearest_sq, effort), searched);
  Search search = search_of(found->at, radius_sq, effort->slack, effort->kept);
  search_tree(&search, tree);
  found->nearest_sq = select(found->nearest_sq, search.distances_sq[0], searched);
  found->nearest = select(found->nearest, search.positions[0], searched);
  // Of what is so far that its square is infinite nothing is known.
  const float16 bound_sq = min(search.walk.bound_sq, MAXFLOAT);
  const float16 rows[5] = {search.walk.queries.x,
                           search.walk.queries.y,
                           search.walk.queries.z,
                           sqrt(min(search.distances_sq[1], bound_sq)),
                           sqrt(bound_sq)};
  for (uint r = 0; r < 5; ++r) {
    global float* row = source->searched_at + i + r * source->stride;
    vstore16(select(vload16(0, row), rows[r], searched), 0, row);
  }
  for (uint k = 0; k < KEPT_CANDIDATES; ++k) {
    global int* row = source->candidates + i + k * source->stride;
    vstore16(select(vload16(0, row), search.positions[k], searched), 0, row);
  }
}

// One work-item per block of POINTS_PER_MATCH_BLOCK source points; so are the others. Returns how many are matched.
static inline uint accumulate_block(const Source* source,
                                    float16 pose,
                                    global const float* restrict leaves,
                                    global real* restrict partials)
{
  const uint begin = get_block() * POINTS_PER_MATCH_BLOCK;
  const uint end = min(begin + POINTS_PER_MATCH_BLOCK, source->n);
  real_lanes sums[SUMS_PER_BLOCK];
  for (int s = 0; s < SUMS_PER_BLOCK; ++s)
    sums[s] = 0;
  uint count = 0;
  for (uint i = begin; i < end; i += 16) {
    const Points p = moved(source, i, pose);
    const int16 match = vload16(0, source->matches + i);
    const int16 matched = match >= 0 && LANE_NUMBERS < (int16)(source->n - i);
    const Points q = gathered(leaves, match);
    count += count_of(matched);
    add_pairs(sums, p, q, squared_distance(p, q), matched);
  }
  for (int s = 0; s < SUMS_PER_BLOCK; ++s)
    partials[get_block() * SUMS_PER_BLOCK + s] = sum_lanes(sums[s]);
  return count;
}

// Returns how many points had to be searched for.
static inline uint match_block(const Source* source, float16 pose, const Tree* tree, const Effort* effort)
{
  const uint begin = get_block() * POINTS_PER_MATCH_BLOCK;
  const uint end = min(begin + POINTS_PER_MATCH_BLOCK, source->n);
  uint searched = 0;
  for (uint i = begin; i < end; i += 16) {
    Candidates found = look_at_candidates(source, i, pose, tree->leaves, effort);
    if (any_of(found.uncertain)) {
      search_uncertain(source, i, tree, effort, &found);
      searched += count_of(found.uncertain);
    }
    const int16 matched = found.there && found.nearest_sq < effort->limit_sq;
    vstore16(select((int16)(-1), found.nearest, matched), 0, source->matches + i);
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
  float4 waiting[POINTS_PER_MATCH_BLOCK];
  uint waiting_points[POINTS_PER_MATCH_BLOCK];
  uint count = 0;
  for (uint i = begin; i < end; i += 16) {
    const Candidates found = look_at_candidates(source, i, pose, leaves, effort);
    const int16 matched = found.there && found.nearest_sq < effort->limit_sq;
    vstore16(select((int16)(-1), found.nearest, matched), 0, source->matches + i);
    if (!any_of(found.uncertain))
      continue;
    float x[16], y[16], z[16], start_sq[16];
    int uncertain[16];
    vstore16(found.at.x, 0, x);
    vstore16(found.at.y, 0, y);
    vstore16(found.at.z, 0, z);
    vstore16(start_of(found.nearest_sq, effort), 0, start_sq);
    vstore16(found.uncertain, 0, uncertain);
    for (uint lane = 0; lane < 16; ++lane)
      if (uncertain[lane]) {
        waiting[count] = (float4)(x[lane], y[lane], z[lane], start_sq[lane]);
        waiting_points[count++] = i + lane;
      }
  }
  const uint first = atomic_add((volatile global uint*)queries, count);
  for (uint j = 0; j < count; ++j) {
    queries[1 + first + j] = waiting[j];
    queried[first + j] = waiting_points[j];
  }
}

#endif
