// The walk on CPUs: sixteen queries together, a lane each. Included by tree.h, which says what the tree is.
#ifndef PCL_GPU_ICP_TREE_CHUNKED_H
#define PCL_GPU_ICP_TREE_CHUNKED_H

// Sixteen points, or sixteen values of each coordinate.
typedef struct {
  float16 x, y, z;
} Points;

#define LANE_NUMBERS (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)

// What sixteen queries that walk the tree together look for: a lane each. Queries should lie together.
typedef struct {
  Points queries;
  float16
      radius_sq;    // points at this distance or farther are not looked for; may shrink. A lane of -1 looks for nothing
  float16 bound_sq; // what was left out is no nearer than this
} Walk;

// What comes of a leaf within some lane's radius: of the file that includes this one, whose search begins with a Walk.
// first: position in the leaves of the first of its points
static inline void look_at_leaf(Walk* walk, global const float* restrict points, int first);

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
static inline void walk_tree(Walk* walk, const Tree* tree)
{
  const int16 searching = walk->radius_sq >= 0;
  const Points q = walk->queries;
  const float16 infinite = INFINITY;
  const float3 low = (float3)(least_float(select(infinite, q.x, searching)),
                              least_float(select(infinite, q.y, searching)),
                              least_float(select(infinite, q.z, searching)));
  const float3 high = (float3)(greatest(select(-infinite, q.x, searching)),
                               greatest(select(-infinite, q.y, searching)),
                               greatest(select(-infinite, q.z, searching)));
  float greatest_radius_sq = greatest(walk->radius_sq);
  uint pending[TREE_LEVELS * NODE_CHILDREN];
  uint level = tree->root_level, node = 0;
  vstore16(child_keys(low, high, node_of(tree, level, node)), level, pending);
  bool done = false;
  while (!done) {
    const uint16 keys = vload16(level, pending);
    const uint key = least(keys);
    const float nearest_sq = as_float(key & ~15u);
    if (!(nearest_sq < greatest_radius_sq)) {
      walk->bound_sq = min(walk->bound_sq, nearest_sq);
      done = level == tree->root_level;
      ++level;
      node /= NODE_CHILDREN;
    }
    else {
      vstore16(select(keys, as_uint16(infinite), keys == key), level, pending);
      const float16 distances_sq = box_distances(q, node_of(tree, level, node), key & 15u);
      const int16 near = distances_sq < walk->radius_sq;
      walk->bound_sq = min(walk->bound_sq, select(distances_sq, infinite, near));
      if (any_of(near)) {
        const uint child = node * NODE_CHILDREN + (key & 15u);
        if (level == 0) {
          look_at_leaf(walk, tree->leaves + child * LEAF_WORDS, child * LEAF_POINTS);
          greatest_radius_sq = greatest(walk->radius_sq);
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
