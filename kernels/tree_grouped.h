// The search on GPUs: each query walks the tree on a work-item of its own. Included by tree.h, which says what the tree
// is.
#ifndef PCL_GPU_ICP_TREE_GROUPED_H
#define PCL_GPU_ICP_TREE_GROUPED_H

// A search and what it has found so far.
typedef struct {
  float3 query;
  float radius_sq;               // points at this distance or farther are not looked for; shrinks
  float slack;                   // what is this much farther than the nearest is looked for, too
  float bound_sq;                // nothing that is not kept is nearer than this
  uint kept;                     // how many to keep
  float distances_sq[KEPT_MOST]; // ascending; INFINITY where there is none
  int positions[KEPT_MOST];      // in the leaves; -1 where there is none
} Search;

static inline Search search_of(float3 query, float radius_sq, float slack, uint kept)
{
  Search search = {query, radius_sq, slack, INFINITY, kept, {0}, {0}};
  for (uint i = 0; i < KEPT_MOST; ++i) {
    search.distances_sq[i] = INFINITY;
    search.positions[i] = -1;
  }
  return search;
}

// Keeps a point nearer than the radius.
static inline void keep(Search* search, float distance_sq, int position)
{
  uint i = search->kept - 1;
  search->bound_sq = min(search->bound_sq, search->distances_sq[i]);
  for (; i > 0 && search->distances_sq[i - 1] > distance_sq; --i) {
    search->distances_sq[i] = search->distances_sq[i - 1];
    search->positions[i] = search->positions[i - 1];
  }
  search->distances_sq[i] = distance_sq;
  search->positions[i] = position;
  float radius_sq = search->distances_sq[search->kept - 1];
  if (search->slack < INFINITY) {
    const float reach = sqrt(search->distances_sq[0]) + search->slack;
    radius_sq = min(radius_sq, max(reach * reach, search->distances_sq[0]));
  }
  search->radius_sq = min(search->radius_sq, radius_sq);
}

static inline float box_distance(global const float* node, uint child, float3 q)
{
  global const float* box = node + child;
  const float dx = max(max(box[0] - q.x, q.x - box[3 * NODE_CHILDREN]), 0.0f);
  const float dy = max(max(box[NODE_CHILDREN] - q.y, q.y - box[4 * NODE_CHILDREN]), 0.0f);
  const float dz = max(max(box[2 * NODE_CHILDREN] - q.z, q.z - box[5 * NODE_CHILDREN]), 0.0f);
  return dx * dx + dy * dy + dz * dz;
}

static inline void search_leaf(Search* search, global const float* leaves, uint leaf)
{
  for (uint lane = 0; lane < LEAF_POINTS; ++lane) {
    const uint position = leaf * LEAF_POINTS + lane;
    const float3 d = leaf_point(leaves, position) - search->query;
    const float distance_sq = d.x * d.x + d.y * d.y + d.z * d.z;
    if (distance_sq < search->radius_sq)
      keep(search, distance_sq, position);
    else
      search->bound_sq = min(search->bound_sq, distance_sq);
  }
}

// Depth first, the nearest child of a node first, the others in their order. `pending` has a bit for each child that is
// still to be looked at.
static inline void search_tree(Search* search, const Tree* tree)
{
  ushort pending[TREE_LEVELS];
  uint level = tree->root_level, node = 0;
  bool entered = false;
  for (;;) {
    global const float* boxes = tree->nodes + (tree->first_node[level] + node) * NODE_WORDS;
    uint next = NODE_CHILDREN;
    if (!entered) {
      uint near = 0;
      float nearest_sq = search->radius_sq;
      for (uint child = 0; child < NODE_CHILDREN; ++child) {
        const float distance_sq = box_distance(boxes, child, search->query);
        if (distance_sq < search->radius_sq)
          near |= 1u << child;
        else
          search->bound_sq = min(search->bound_sq, distance_sq);
        if (distance_sq < nearest_sq) {
          nearest_sq = distance_sq;
          next = child;
        }
      }
      pending[level] = near;
      entered = true;
    }
    else
      while (pending[level] && next == NODE_CHILDREN) {
        const uint child = 31 - clz((uint)pending[level]);
        const float distance_sq = box_distance(boxes, child, search->query);
        if (distance_sq < search->radius_sq)
          next = child;
        else {
          pending[level] &= ~(1u << child);
          search->bound_sq = min(search->bound_sq, distance_sq);
        }
      }
    if (next == NODE_CHILDREN) {
      if (level == tree->root_level)
        return;
      ++level;
      node /= NODE_CHILDREN;
      continue;
    }
    pending[level] &= ~(1u << next);
    const uint child = node * NODE_CHILDREN + next;
    if (level == 0)
      search_leaf(search, tree->leaves, child);
    else {
      --level;
      node = child;
      entered = false;
    }
  }
}

#endif
