// Which of the blocks that a launch is about is meant: a work-group's, or a work-item's on CPUs. Their number is always
// an argument: a launch may be one of several passes over the blocks, of which neither get_group_id() nor any size
// tells.
#ifndef PCL_GPU_ICP_BLOCK_H
#define PCL_GPU_ICP_BLOCK_H

static inline uint get_block(void)
{
#ifdef CHUNKED
  return get_global_id(0);
#else
  return get_global_id(0) / WORK_GROUP_SIZE;
#endif
}

#endif
