// The search on CPUs: sixteen queries walk the tree together, a lane each. Included by tree.h, which says what the tree
// is.
#ifndef PCL_GPU_ICP_TREE_CHUNKED_H
#define PCL_GPU_ICP_TREE_CHUNKED_H

// Sixteen points, or sixteen values of each coordinate.
typedef struct {
  float16 x, y, z;
} Points;

#define LANE_NUMBERS (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)

// Sixteen searches, which walk the tree together: a lane each. Queries should lie together.
typedef struct {
  Points queries;
  float16 radius_sq; // points at this distance or farther are not looked for; shrinks. A lane of -1 looks for nothing
  float slack;       // what is this much farther than the nearest is looked for, too
  float16 bound_sq;  // nothing that is not kept is nearer than this
  uint kept;         // how many to keep
  float16 distances_sq[KEPT_MOST]; // ascending; INFINITY where there is none
  int16 positions[KEPT_MOST];      // in the leaves; -1 where there is none
} Search;

static inline Search search_of(Points queries, float16 radius_sq, float slack, uint kept)
{
  Search search = {queries, radius_sq, slack, INFINITY, kept};
  for (uint i = 0; i < KEPT_MOST; ++i) {
    search.distances_sq[i] = INFINITY;
    search.positions[i] = -1;
  }
  return search;
}

static inline uint least(uint16 v)
{
  const uint8 a = min(v.lo, v.hi);
  const uint4 b = min(a.lo, a.hi);
  const uint2 c = min(b.lo, b.hi);
  return min(c.x, c.y);
}

static inline float least_float(float16 v)
{
  const float8 a = min(v.lo, v.hi);
  const float4 b = min(a.lo, a.hi);
  const float2 c = min(b.lo, b.hi);
  return min(c.x, c.y);
}

static inline bool any_of(int16 flags)
{
  const int8 a = flags.lo | flags.hi;
  const int4 b = a.lo | a.hi;
  const int2 c = b.lo | b.hi;
  return (c.x | c.y) != 0;
}

static inline float greatest(float16 v) { return -least_float(-v); }

static inline float16 point_distances(Points q, global const float* restrict point)
{
  const float16 dx = q.x - point[0], dy = q.y - point[LEAF_POINTS], dz = q.z - point[2 * LEAF_POINTS];
  return dx * dx + dy * dy + dz * dz;
}

// Each lane keeps its nearest point of a leaf, if that is nearer than what it has.
static inline void keep_nearest(Search* search, global const float* restrict points, int first)
{
  float16 radius_sq = search->radius_sq, nearest_sq = search->distances_sq[0], bound_sq = search->bound_sq;
  int16 nearest = search->positions[0];
#pragma unroll
  for (int i = 0; i < LEAF_POINTS; ++i) {
    const float16 distance_sq = point_distances(search->queries, points + i);
    const int16 nearer = distance_sq < radius_sq;
    bound_sq = min(bound_sq, select(distance_sq, nearest_sq, nearer));
    nearest_sq = select(nearest_sq, distance_sq, nearer);
    nearest = select(nearest, (int16)(first + i), nearer);
    radius_sq = min(radius_sq, distance_sq);
  }
  search->radius_sq = radius_sq;
  search->distances_sq[0] = nearest_sq;
  search->bound_sq = bound_sq;
  search->positions[0] = nearest;
}

// Each lane keeps its nearest few points of a leaf.
static inline void keep_few(Search* search, global const float* restrict points, int first)
{
  for (int i = 0; i < LEAF_POINTS; ++i) {
    const float16 distance_sq = point_distances(search->queries, points + i);
    const int16 near = distance_sq < search->radius_sq;
    // Insertion from the nearest on; what a lane carries past the last is what it does not keep.
    float16 carried_sq = distance_sq;
    int16 carried = first + i;
    if (any_of(near))
      for (uint k = 0; k < search->kept; ++k) {
        const int16 nearer = near && carried_sq < search->distances_sq[k];
        const float16 moved_sq = search->distances_sq[k];
        const int16 moved = search->positions[k];
        search->distances_sq[k] = select(moved_sq, carried_sq, nearer);
        search->positions[k] = select(moved, carried, nearer);
        carried_sq = select(carried_sq, moved_sq, nearer);
        carried = select(carried, moved, nearer);
      }
    search->bound_sq = min(search->bound_sq, carried_sq);
  }
  const float16 reach = sqrt(search->distances_sq[0]) + search->slack;
  const float16 radius_sq = max(reach * reach, search->distances_sq[0]);
  search->radius_sq = min(search->radius_sq, min(radius_sq, search->distances_sq[search->kept - 1]));
}

static inline float16 outside(float16 q, float low, float high) { return max(max(low - q, q - high), 0.0f); }

// Squared distances from the queries to a child's box.
static inline float16 box_distances(Points q, global const float* restrict node, uint child)
{
  global const float* box = node + child;
  const float16 dx = outside(q.x, box[0], box[3 * NODE_CHILDREN]);
  const float16 dy = outside(q.y, box[NODE_CHILDREN], box[4 * NODE_CHILDREN]);
  const float16 dz = outside(q.z, box[2 * NODE_CHILDREN], box[5 * NODE_CHILDREN]);
  return dx * dx + dy * dy + dz * dz;
}

// Squared distances from the box [low, high] to the boxes of a node's children as sortable integers, each with its
// child in the low four bits. What a distance loses by that makes it smaller: still a bound.
static inline uint16 child_keys(float3 low, float3 high, global const float* restrict node)
{
  const float16 dx = max(max(vload16(0, node) - high.x, low.x - vload16(3, node)), 0.0f);
  const float16 dy = max(max(vload16(1, node) - high.y, low.y - vload16(4, node)), 0.0f);
  const float16 dz = max(max(vload16(2, node) - high.z, low.z - vload16(5, node)), 0.0f);
  return (as_uint16(dx * dx + dy * dy + dz * dz) & ~15u) | as_uint16(LANE_NUMBERS);
}

// Where a node's boxes are.
static inline global const float* node_of(const Tree* tree, uint level, uint node)
{
  const uint* first_node = (const uint*)&tree->first_node;
  return tree->nodes + (first_node[level] + node) * NODE_WORDS;
}

// Depth first, the child nearest to the queries' box first. `pending` holds each level's children that are still to be
// looked at.
static inline void search_tree(Search* search, const Tree* tree)
{
  const int16 searching = search->radius_sq >= 0;
  const Points q = search->queries;
  const float16 infinite = INFINITY;
  const float3 low = (float3)(least_float(select(infinite, q.x, searching)),
                              least_float(select(infinite, q.y, searching)),
                              least_float(select(infinite, q.z, searching)));
  const float3 high = (float3)(greatest(select(-infinite, q.x, searching)),
                               greatest(select(-infinite, q.y, searching)),
                               greatest(select(-infinite, q.z, searching)));
  float greatest_radius_sq = greatest(search->radius_sq);
  uint pending[TREE_LEVELS * NODE_CHILDREN];
  uint level = tree->root_level, node = 0;
  vstore16(child_keys(low, high, node_of(tree, level, node)), level, pending);
  bool done = false;
  while (!done) {
    const uint16 keys = vload16(level, pending);
    const uint key = least(keys);
    const float nearest_sq = as_float(key & ~15u);
    if (!(nearest_sq < greatest_radius_sq)) {
      search->bound_sq = min(search->bound_sq, nearest_sq);
      done = level == tree->root_level;
      ++level;
      node /= NODE_CHILDREN;
    }
    else {
      vstore16(select(keys, as_uint16(infinite), keys == key), level, pending);
      const float16 distances_sq = box_distances(q, node_of(tree, level, node), key & 15u);
      const int16 near = distances_sq < search->radius_sq;
      search->bound_sq = min(search->bound_sq, select(distances_sq, infinite, near));
      if (any_of(near)) {
        const uint child = node * NODE_CHILDREN + (key & 15u);
        if (level == 0) {
          if (search->kept == 1)
            keep_nearest(search, tree->leaves + child * LEAF_WORDS, child * LEAF_POINTS);
          else
            keep_few(search, tree->leaves + child * LEAF_WORDS, child * LEAF_POINTS);
          greatest_radius_sq = greatest(search->radius_sq);
        }
        else {
          --level;
          node = child;
          vstore16(child_keys(low, high, node_of(tree, level, node)), level, pending);
        }
      }
    }
  }
}

#endif
