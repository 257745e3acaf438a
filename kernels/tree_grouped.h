// The search on GPUs: each query walks the tree on a work-item of its own. Included by tree.h, which says what the tree
// is.
#ifndef PCL_GPU_ICP_TREE_GROUPED_H
#define PCL_GPU_ICP_TREE_GROUPED_H

// A search and what it has found so far.
typedef struct {
  float3 query;
  float radius_sq;             // points at this distance or farther are not looked for; shrinks
  float slack;                 // what is this much farther than the nearest is looked for, too
  float bound_sq;              // nothing that is not kept is nearer than this
  float nearest_sq, second_sq; // distances found; INFINITY where there is none
  int nearest;                 // position in the leaves; -1 where there is none
  uint kept;                   // how many to keep
  // Of those: the last places of the lists, so that the last one is the same whatever their number is.
  float distances_sq[KEPT_MOST]; // ascending; INFINITY where there is none, -INFINITY where not in use
  int positions[KEPT_MOST];      // -1 where there is none
} Search;

static inline Search search_of(float3 query, float radius_sq, float slack, uint kept)
{
  Search search = {query, radius_sq, slack, INFINITY, INFINITY, INFINITY, -1, kept, {0}, {0}};
#pragma unroll
  for (uint i = 0; i < KEPT_MOST; ++i) {
    search.distances_sq[i] = i < KEPT_MOST - kept ? -INFINITY : INFINITY;
    search.positions[i] = -1;
  }
  return search;
}

// Keeps a point if it is nearer than the radius. Without a branch, because some work-item of those that run together
// takes it anyway; every place is looked at, and none by a variable: the lists are in registers.
static inline void look_at_point(Search* search, float distance_sq, int position)
{
  float* distances_sq = search->distances_sq;
  int* positions = search->positions;
  const bool near = distance_sq < search->radius_sq;
  const float kept_sq = near ? distance_sq : INFINITY; // which no place takes
  search->bound_sq = min(search->bound_sq, near ? distances_sq[KEPT_MOST - 1] : distance_sq);
#pragma unroll
  for (uint i = KEPT_MOST - 1; i > 0; --i) {
    const int here_or_not = kept_sq < distances_sq[i] ? position : positions[i];
    positions[i] = kept_sq < distances_sq[i - 1] ? positions[i - 1] : here_or_not;
    distances_sq[i] = clamp(kept_sq, distances_sq[i - 1], distances_sq[i]);
  }
  positions[0] = kept_sq < distances_sq[0] ? position : positions[0];
  distances_sq[0] = min(kept_sq, distances_sq[0]);
  search->second_sq = min(search->second_sq, max(search->nearest_sq, kept_sq));
  search->nearest = kept_sq < search->nearest_sq ? position : search->nearest;
  search->nearest_sq = min(search->nearest_sq, kept_sq);
  search->radius_sq = min(search->radius_sq, distances_sq[KEPT_MOST - 1]);
  if (search->slack < INFINITY) {
    const float reach = sqrt(search->nearest_sq) + search->slack;
    search->radius_sq = min(search->radius_sq, max(reach * reach, search->nearest_sq));
  }
}

// Which place of what is kept, the nearest at 0, the list's place i is; those that are not in use come last.
static inline uint rank_of(const Search* search, uint i) { return (i + search->kept) % KEPT_MOST; }

// Four points at a time: so wide are loads, and more at a time would take registers that other work-items run on.
static inline void search_leaf(Search* search, global const float* leaves, uint leaf)
{
  global const float4* points = (global const float4*)(leaves + leaf * LEAF_WORDS);
#pragma unroll 1
  for (uint four = 0; four < LEAF_POINTS / 4; ++four) {
    const float4 dx = points[four] - search->query.x;
    const float4 dy = points[four + LEAF_POINTS / 4] - search->query.y;
    const float4 dz = points[four + 2 * LEAF_POINTS / 4] - search->query.z;
    const float4 distances_sq = dx * dx + dy * dy + dz * dz;
    const int position = leaf * LEAF_POINTS + 4 * four;
    look_at_point(search, distances_sq.x, position);
    look_at_point(search, distances_sq.y, position + 1);
    look_at_point(search, distances_sq.z, position + 2);
    look_at_point(search, distances_sq.w, position + 3);
  }
}

static inline float4 outside(float q, float4 low, float4 high) { return max(max(low - q, q - high), 0.0f); }

// Squared distances to the boxes of a node's children [4 four, 4 four + 4).
static inline float4 box_distances(global const float* node, uint four, float3 q)
{
  global const float4* boxes = (global const float4*)node + four;
  const float4 dx = outside(q.x, boxes[0], boxes[3 * NODE_CHILDREN / 4]);
  const float4 dy = outside(q.y, boxes[NODE_CHILDREN / 4], boxes[4 * NODE_CHILDREN / 4]);
  const float4 dz = outside(q.z, boxes[2 * NODE_CHILDREN / 4], boxes[5 * NODE_CHILDREN / 4]);
  return dx * dx + dy * dy + dz * dz;
}

// Children of a node that are still to be looked at, a bit each, and which of them is next, nearest_sq away.
typedef struct {
  uint pending;
  uint next;
  float nearest_sq;
} Children;

static inline void look_at_child(Search* search, float distance_sq, uint child, Children* children)
{
  if (distance_sq < search->radius_sq)
    children->pending |= 1u << child;
  else
    search->bound_sq = min(search->bound_sq, distance_sq);
  children->next = distance_sq < children->nearest_sq ? child : children->next;
  children->nearest_sq = min(children->nearest_sq, distance_sq);
}

static inline void look_at_children(Search* search, global const float* node, Children* children)
{
  children->pending = 0;
  children->next = NODE_CHILDREN;
  children->nearest_sq = search->radius_sq;
#pragma unroll 1
  for (uint four = 0; four < NODE_CHILDREN / 4; ++four) {
    const float4 distances_sq = box_distances(node, four, search->query);
    look_at_child(search, distances_sq.x, 4 * four, children);
    look_at_child(search, distances_sq.y, 4 * four + 1, children);
    look_at_child(search, distances_sq.z, 4 * four + 2, children);
    look_at_child(search, distances_sq.w, 4 * four + 3, children);
  }
}

// The next of the pending children, as far as they are still near enough.
static inline void look_again(Search* search, global const float* node, Children* children)
{
  children->next = NODE_CHILDREN;
  while (children->pending && children->next == NODE_CHILDREN) {
    const uint child = 31 - clz(children->pending);
    const float4 distances_sq = box_distances(node, child / 4, search->query);
    const float2 two = child & 2 ? distances_sq.hi : distances_sq.lo;
    const float distance_sq = child & 1 ? two.y : two.x;
    if (distance_sq < search->radius_sq)
      children->next = child;
    else {
      children->pending &= ~(1u << child);
      search->bound_sq = min(search->bound_sq, distance_sq);
    }
  }
}

// Where a node's boxes are. Chosen by halves: what is indexed by a variable lies in a GPU's memory.
static inline global const float* node_of(const Tree* tree, uint level, uint node)
{
  const uint4 four = level & 4 ? tree->first_node.hi : tree->first_node.lo;
  const uint2 two = level & 2 ? four.hi : four.lo;
  return tree->nodes + ((level & 1 ? two.y : two.x) + node) * NODE_WORDS;
}

// Depth first, the nearest child of a node first, the others in their order. `above` holds what is pending of the nodes
// on the way to the root, that of the next one in its lowest bits: shifted, where a stack would lie in memory.
static inline void search_tree(Search* search, const Tree* tree)
{
  uint level = tree->root_level, node = 0;
  ulong2 above = 0;
  Children children;
  bool arrived = true;
  for (;;) {
    global const float* boxes = node_of(tree, level, node);
    if (arrived)
      look_at_children(search, boxes, &children);
    else
      look_again(search, boxes, &children);
    arrived = false;
    if (children.next == NODE_CHILDREN) {
      if (level == tree->root_level)
        return;
      ++level;
      node /= NODE_CHILDREN;
      children.pending = above.x & ((1u << NODE_CHILDREN) - 1);
      above = (ulong2)(above.x >> NODE_CHILDREN | above.y << (64 - NODE_CHILDREN), above.y >> NODE_CHILDREN);
      continue;
    }
    children.pending &= ~(1u << children.next);
    const uint child = node * NODE_CHILDREN + children.next;
    if (level == 0) {
      search_leaf(search, tree->leaves, child);
      continue;
    }
    --level;
    node = child;
    above = (ulong2)(above.x << NODE_CHILDREN | children.pending,
                     above.y << NODE_CHILDREN | above.x >> (64 - NODE_CHILDREN));
    arrived = true;
  }
}

#endif
