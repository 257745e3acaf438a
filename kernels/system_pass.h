// The pass over the pairs that every metric makes, and the sum over its blocks. Included by a metric's file, see
// system.h.

#define ROWS (POINT_ROWS + OWN_ROWS)

// One pair, or as many as lanes are, of rows p, q and the metric's own. Returns the squared residual.
static inline lane add_rows(lane* sums, const lane* row, float4 centre, float16 turn, Loss loss)
{
  const lane x[3] = {row[0] - (real)centre.x, row[1] - (real)centre.y, row[2] - (real)centre.z};
  const lane e[3] = {row[3] - row[0], row[4] - row[1], row[5] - row[2]};
  return add_equations(sums, x, e, row + POINT_ROWS, turn, loss);
}

// source_points, stride, n, pose, matches: as in match.cl; from the last source point to the stride matches are -1
// own_target, own_source: what the metric knows of the points
// turn: the pose whose rotation the metric weighs by
// centre: c, in the target's frame
// loss_function: LOSS_; loss_scale: c, see loss.h
// residuals: where keeps_residuals is not 0, of each source point the root of s; INFINITY: it has no pair
// partials: SYSTEM_SUMS_ROWS rows of SUMS_PER_BLOCK sums for each block
// One work-item per block of POINTS_PER_MATCH_BLOCK source points; or a work-group of WORK_GROUP_SIZE, a power of two.
kernel void system_sums(global const float* source_points,
                        global int* matches,
                        uint stride,
                        uint n,
                        float16 pose,
                        global const float* restrict leaves,
                        global const float* restrict own_target,
                        global const float* restrict own_source,
                        float16 turn,
                        float4 centre,
                        uint loss_function,
                        float loss_scale,
                        uint keeps_residuals,
                        global float* restrict residuals,
                        uint blocks,
                        global real* restrict partials)
{
  const Source source = {source_points, 0, 0, matches, stride, n};
  const Own own = {own_target, own_source, stride};
  const Loss loss = {loss_function, (real)loss_scale * loss_scale};
  const uint block = get_block();
  const uint begin = block * POINTS_PER_MATCH_BLOCK;
  const uint end = min(begin + POINTS_PER_MATCH_BLOCK, n);
  float rows[ROWS][PAIRS_AT_ONCE];
  int positions[PAIRS_AT_ONCE];
  float residual[PAIRS_AT_ONCE];
  lane sums[SYSTEM_SUMS_ROWS * SUMS_PER_BLOCK];
  for (int s = 0; s < SYSTEM_SUMS_ROWS * SUMS_PER_BLOCK; ++s)
    sums[s] = 0;
#ifdef CHUNKED
  for (uint i = begin; i < end; i += PAIRS_AT_ONCE) {
    const int16 match = vload16(0, matches + i);
    const int16 matched = match >= 0;
    const Points p = moved(&source, i, pose), q = gathered(leaves, match);
    store_pairs(p, q, matched, rows);
    vstore16(match, 0, positions);
    load_own(rows + POINT_ROWS, &own, i, positions);
    for (int part = 0; part < PAIRS_AT_ONCE; part += LANES) {
      lane row[ROWS];
      for (int r = 0; r < ROWS; ++r)
        row[r] = load_lanes(rows[r] + part);
      const lane squared = add_rows(sums, row, centre, turn, loss);
      if (keeps_residuals)
        store_lanes(sqrt(squared), residual + part);
    }
    if (keeps_residuals)
      for (uint k = 0; k < PAIRS_AT_ONCE; ++k)
        residuals[i + k] = rows[POINT_ROWS][k] > 0 ? residual[k] : INFINITY;
  }
  for (int s = 0; s < SYSTEM_SUMS_ROWS * SUMS_PER_BLOCK; ++s)
    partials[(s / SUMS_PER_BLOCK * blocks + block) * SUMS_PER_BLOCK + s % SUMS_PER_BLOCK] = sum_lanes(sums[s]);
#else
  local real4 scratch[WORK_GROUP_SIZE];
  const uint item = get_local_id(0);
  for (uint i = begin + item; i < end; i += WORK_GROUP_SIZE) {
    positions[0] = matches[i];
    if (keeps_residuals)
      residuals[i] = INFINITY;
    if (positions[0] < 0)
      continue;
    const float3 p = moved(&source, i, pose), q = leaf_point(leaves, positions[0]);
    load_own(rows + POINT_ROWS, &own, i, positions);
    lane row[ROWS] = {p.x, p.y, p.z, q.x, q.y, q.z};
    for (int r = POINT_ROWS; r < ROWS; ++r)
      row[r] = rows[r][0];
    residual[0] = sqrt(add_rows(sums, row, centre, turn, loss));
    if (keeps_residuals && rows[POINT_ROWS][0] > 0)
      residuals[i] = residual[0];
  }
#pragma unroll
  for (int s = 0; s < SYSTEM_SUMS_ROWS * SUMS_PER_BLOCK; s += 4)
    sum_over_group((real4)(sums[s], sums[s + 1], sums[s + 2], sums[s + 3]),
                   scratch,
                   partials + (s / SUMS_PER_BLOCK * blocks + block) * SUMS_PER_BLOCK + s % SUMS_PER_BLOCK);
#endif
}

// One work-group of SUMS_PER_BLOCK work-items, or one work-item. total: SYSTEM_SUMS values
kernel void system_total(global const real* restrict partials, uint blocks, global real* restrict total)
{
  SUMS_SPACE real sums[SYSTEM_SUMS_ROWS * SUMS_PER_BLOCK], lost[SYSTEM_SUMS_ROWS * SUMS_PER_BLOCK];
  for (int row = 0; row < SYSTEM_SUMS_ROWS; ++row)
    add_partials(
        partials + row * blocks * SUMS_PER_BLOCK, blocks, sums + row * SUMS_PER_BLOCK, lost + row * SUMS_PER_BLOCK);
  if (get_local_id(0) == 0)
    for (int s = 0; s < SYSTEM_SUMS; ++s)
      total[s] = sums[s] + lost[s];
}
