// Surface normals: at every query the direction in which the covariance of its nearest points is least (Hoppe et al.
// 1992): a unit vector, or NaN where the points do not span a plane.
#define KEPT_MOST NEAREST_MOST
#include "block.h"
#include "least_direction.h"
#include "tree.h"
#pragma OPENCL FP_CONTRACT ON

// What neighbours sum up to, their coordinates about the query's.
typedef struct {
  lanes count, x, y, z;
  Symmetric products;
} Moments;

// Coordinates are 0 where the count is.
static inline void add(Moments* m, lanes count, lanes x, lanes y, lanes z)
{
  m->count += count;
  m->x += x;
  m->y += y;
  m->z += z;
  m->products.xx += x * x;
  m->products.xy += x * y;
  m->products.xz += x * z;
  m->products.yy += y * y;
  m->products.yz += y * z;
  m->products.zz += z * z;
}

// resolution_sq: variance below which a direction is only the coordinates' rounding
static inline Direction normal_of(const Moments* m, float resolution_sq)
{
  const lanes each = 1 / m->count;
  const Symmetric about_mean = {m->products.xx - m->x * m->x * each,
                                m->products.xy - m->x * m->y * each,
                                m->products.xz - m->x * m->z * each,
                                m->products.yy - m->y * m->y * each,
                                m->products.yz - m->y * m->z * each,
                                m->products.zz - m->z * m->z * each};
  const lanes shrink = 1 / trace(about_mean);
  return least_direction(scaled(about_mean, shrink),
                         fmax((lanes)(16 * REAL_EPSILON), m->count * resolution_sq * shrink));
}

#ifdef CHUNKED

// Sixteen queries' neighbours: how far they are on a first walk, and what they sum up to on a second.
typedef struct {
  Walk walk;
  bool sums;
  uint k;
  float16 distances_sq[NEAREST_MOST]; // of the k nearest, ascending
  Moments moments;
} Neighbourhood;

// Four points at a time: a row is loaded and stored once for them.
static inline void keep_distances(Neighbourhood* found, global const float* restrict points)
{
  for (int i = 0; i < LEAF_POINTS; i += 4) {
    float16 carried_sq[4];
#pragma unroll
    for (int j = 0; j < 4; ++j)
      carried_sq[j] = point_distances(found->walk.queries, points + i + j);
    const float16 nearest_sq = min(min(carried_sq[0], carried_sq[1]), min(carried_sq[2], carried_sq[3]));
    if (!any_of(nearest_sq < found->walk.radius_sq))
      continue;
    for (uint row = 0; row < found->k; ++row) {
      float16 here_sq = found->distances_sq[row];
#pragma unroll
      for (int j = 0; j < 4; ++j) {
        const float16 farther_sq = max(here_sq, carried_sq[j]);
        here_sq = min(here_sq, carried_sq[j]);
        carried_sq[j] = farther_sq;
      }
      found->distances_sq[row] = here_sq;
    }
    found->walk.radius_sq = min(found->walk.radius_sq, found->distances_sq[found->k - 1]);
  }
}

static inline void add_up(Neighbourhood* found, global const float* restrict points)
{
  const Points q = found->walk.queries;
  Moments m = found->moments;
  for (int i = 0; i < LEAF_POINTS; ++i) {
    const int16 far = point_distances(q, points + i) >= found->walk.radius_sq;
    if (!any_of(!far))
      continue;
    add(&m,
        lanes_of(select((float16)(1), 0.0f, far)),
        lanes_of(select(points[i] - q.x, 0.0f, far)),
        lanes_of(select(points[i + LEAF_POINTS] - q.y, 0.0f, far)),
        lanes_of(select(points[i + 2 * LEAF_POINTS] - q.z, 0.0f, far)));
  }
  found->moments = m;
}

static inline void look_at_leaf(Walk* walk, global const float* restrict points, int first)
{
  Neighbourhood* found = (Neighbourhood*)walk;
  if (found->sums)
    add_up(found, points);
  else
    keep_distances(found, points);
}

// Of lanes that are not `there` all is zero.
static inline Moments moments_of(Points queries, int16 there, const Tree* tree, uint k)
{
  const float16 nowhere = -1;
  Neighbourhood found = {{queries, select(nowhere, INFINITY, there), INFINITY}, false, k};
  for (uint row = 0; row < k; ++row)
    found.distances_sq[row] = INFINITY;
  walk_tree(&found.walk, tree);
  // The next larger number, so that the farthest of them are within it: all that are as far.
  const float16 farthest_sq = found.distances_sq[k - 1];
  const float16 beyond_sq = select(as_float16(as_int16(farthest_sq) + 1), INFINITY, farthest_sq == INFINITY);
  found.walk.radius_sq = select(nowhere, beyond_sq, there);
  found.sums = true;
  walk_tree(&found.walk, tree);
  return found.moments;
}

#else

static inline Moments moments_of(float3 query, const Tree* tree, uint k)
{
  Search search = search_of(query, INFINITY, INFINITY, k);
  search_tree(&search, tree);
  Moments m = {0};
#pragma unroll
  for (uint place = 0; place < KEPT_MOST; ++place) {
    const int position = search.positions[place];
    const bool is_there = position >= 0;
    const float3 offset = is_there ? leaf_point(tree->leaves, position) - query : (float3)(0);
    add(&m, is_there, offset.x, offset.y, offset.z);
  }
  return m;
}

#endif

// queries, stride, n, k: as in nearest.cl
// normals: rows x, y, z of `stride` floats
// A work-item per block of POINTS_PER_MATCH_BLOCK queries, sixteen at a time; or a work-item per query.
kernel void normals(global const float* restrict queries,
                    uint stride,
                    uint n,
                    global const float* restrict leaves,
                    global const float* restrict nodes,
                    uint8 first_node,
                    uint root_level,
                    uint k,
                    float resolution_sq,
                    global float* restrict normals)
{
  const Tree tree = tree_of(leaves, nodes, first_node, root_level);
#ifdef CHUNKED
  const uint begin = get_block() * POINTS_PER_MATCH_BLOCK;
  const uint end = min(begin + POINTS_PER_MATCH_BLOCK, n);
  for (uint i = begin; i < end; i += 16) {
    const Points q = {vload16(0, queries + i), vload16(0, queries + i + stride), vload16(0, queries + i + 2 * stride)};
    const Moments m = moments_of(q, LANE_NUMBERS < (int16)(n - i), &tree, k);
    const Direction normal = normal_of(&m, resolution_sq);
    vstore16(floats_of(normal.x), 0, normals + i);
    vstore16(floats_of(normal.y), 0, normals + i + stride);
    vstore16(floats_of(normal.z), 0, normals + i + 2 * stride);
  }
#else
  const uint i = get_global_id(0);
  if (i >= n)
    return;
  const Moments m = moments_of((float3)(queries[i], queries[i + stride], queries[i + 2 * stride]), &tree, k);
  const Direction normal = normal_of(&m, resolution_sq);
  normals[i] = normal.x;
  normals[i + stride] = normal.y;
  normals[i + 2 * stride] = normal.z;
#endif
}
