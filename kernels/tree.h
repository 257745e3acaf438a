// The target as a tree of boxes, and the exact search for the points of it nearest to a query.
//
// Points lie in leaves of LEAF_POINTS, sixteen leaves below a node, sixteen nodes below a node, and so on to one root:
// child c of node i is node (or leaf) NODE_CHILDREN * i + c of the level below, so there are no links. A node holds the
// tight boxes of its children. Layout: layout.h; built by src/search/box_tree.cpp.
#ifndef PCL_GPU_ICP_TREE_H
#define PCL_GPU_ICP_TREE_H

#include "real.h"

// KEPT_MOST, which the including file defines: how many points a search keeps at most.

// Squared distances are those of FLANN's tree to the bit.
#pragma OPENCL FP_CONTRACT OFF

typedef struct {
  global const float* leaves;
  global const float* nodes;
  uint8 first_node; // of each of TREE_LEVELS levels, the lowest first, in `nodes`
  uint root_level;
} Tree;

static inline Tree
tree_of(global const float* restrict leaves, global const float* restrict nodes, uint8 first_node, uint root_level)
{
  const Tree tree = {leaves, nodes, first_node, root_level};
  return tree;
}

static inline float3 leaf_point(global const float* restrict leaves, uint position)
{
  global const float* p = leaves + position / LEAF_POINTS * LEAF_WORDS + position % LEAF_POINTS;
  return (float3)(p[0], p[LEAF_POINTS], p[2 * LEAF_POINTS]);
}

#ifdef CHUNKED
#include "tree_chunked.h"
#else
#include "tree_grouped.h"
#endif

#endif
