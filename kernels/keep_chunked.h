// The search on CPUs: each of sixteen queries keeps the nearest points that the walk comes by.
#ifndef PCL_GPU_ICP_KEEP_CHUNKED_H
#define PCL_GPU_ICP_KEEP_CHUNKED_H

#include "tree_chunked.h"

// Sixteen searches and what they have found so far.
typedef struct {
  Walk walk;
  float slack;                     // what is this much farther than the nearest is looked for, too
  uint kept;                       // how many to keep
  float16 distances_sq[KEPT_MOST]; // ascending; INFINITY where there is none
  int16 positions[KEPT_MOST];      // in the leaves; -1 where there is none
} Search;

static inline Search search_of(Points queries, float16 radius_sq, float slack, uint kept)
{
  Search search = {{queries, radius_sq, INFINITY}, slack, kept};
  for (uint i = 0; i < KEPT_MOST; ++i) {
    search.distances_sq[i] = INFINITY;
    search.positions[i] = -1;
  }
  return search;
}

// Each lane keeps its nearest point of a leaf, if that is nearer than what it has.
static inline void keep_nearest(Search* search, global const float* restrict points, int first)
{
  float16 radius_sq = search->walk.radius_sq, nearest_sq = search->distances_sq[0], bound_sq = search->walk.bound_sq;
  int16 nearest = search->positions[0];
#pragma unroll
  for (int i = 0; i < LEAF_POINTS; ++i) {
    const float16 distance_sq = point_distances(search->walk.queries, points + i);
    const int16 nearer = distance_sq < radius_sq;
    bound_sq = min(bound_sq, select(distance_sq, nearest_sq, nearer));
    nearest_sq = select(nearest_sq, distance_sq, nearer);
    nearest = select(nearest, (int16)(first + i), nearer);
    radius_sq = min(radius_sq, distance_sq);
  }
  search->walk.radius_sq = radius_sq;
  search->distances_sq[0] = nearest_sq;
  search->walk.bound_sq = bound_sq;
  search->positions[0] = nearest;
}

// Each lane keeps its nearest few points of a leaf.
static inline void keep_few(Search* search, global const float* restrict points, int first)
{
  for (int i = 0; i < LEAF_POINTS; ++i) {
    const float16 distance_sq = point_distances(search->walk.queries, points + i);
    const int16 near = distance_sq < search->walk.radius_sq;
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
    search->walk.bound_sq = min(search->walk.bound_sq, carried_sq);
  }
  const float16 reach = sqrt(search->distances_sq[0]) + search->slack;
  const float16 radius_sq = max(reach * reach, search->distances_sq[0]);
  search->walk.radius_sq = min(search->walk.radius_sq, min(radius_sq, search->distances_sq[search->kept - 1]));
}

static inline void look_at_leaf(Walk* walk, global const float* restrict points, int first)
{
  Search* search = (Search*)walk;
  if (search->kept == 1)
    keep_nearest(search, points, first);
  else
    keep_few(search, points, first);
}

static inline void search_tree(Search* search, const Tree* tree) { walk_tree(&search->walk, tree); }

#endif
