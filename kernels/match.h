// What the matching kernels know of the source points, and how hard they are to look.
#ifndef PCL_GPU_ICP_MATCH_H
#define PCL_GPU_ICP_MATCH_H

#include "block.h"
#include "real.h"

// More than the rounding of distances, reaches and their sums.
#define CERTAINTY 1.000002f

// What is known of the source points: each of `rows` rows has `stride` entries, the first n of them in use.
typedef struct {
  global const float* points; // 3 rows: x, y, z about the source's pivot
  // 5 rows: x, y, z where it was searched for, the reach of the nearest and that of all kept; 0: it was not
  global float* searched_at;
  global int* candidates; // KEPT_CANDIDATES rows: positions in the leaves, nearest first; -1: none
  global int* matches;    // 1 row: the position matched; -1: none
  uint stride;
  uint n;
} Source;

typedef struct {
  float limit_sq; // matches are nearer than this
  float slack;    // of new searches
  uint kept;      // of new searches
  uint tested;    // the most candidates that a search has kept so far
} Effort;

#endif
