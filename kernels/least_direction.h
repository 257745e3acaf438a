// The direction in which a symmetric matrix without negative eigenvalues is least: the eigenvector of its least
// eigenvalue is that of its adjugate's greatest, and alone is left of the adjugate's powers. A matrix in each lane,
// where there are lanes.
#ifndef PCL_GPU_ICP_LEAST_DIRECTION_H
#define PCL_GPU_ICP_LEAST_DIRECTION_H

#include "real.h"

#ifdef CHUNKED
typedef real_sums lanes;
#else
typedef real lanes;
#endif

typedef struct {
  lanes xx, xy, xz, yy, yz, zz;
} Symmetric;

typedef struct {
  lanes x, y, z;
} Direction;

static inline Symmetric scaled(Symmetric m, lanes by)
{
  const Symmetric result = {m.xx * by, m.xy * by, m.xz * by, m.yy * by, m.yz * by, m.zz * by};
  return result;
}

static inline lanes trace(Symmetric m) { return m.xx + m.yy + m.zz; }

static inline Symmetric adjugate(Symmetric m)
{
  const Symmetric result = {m.yy * m.zz - m.yz * m.yz,
                            m.xz * m.yz - m.xy * m.zz,
                            m.xy * m.yz - m.xz * m.yy,
                            m.xx * m.zz - m.xz * m.xz,
                            m.xy * m.xz - m.xx * m.yz,
                            m.xx * m.yy - m.xy * m.xy};
  return result;
}

static inline Symmetric squared(Symmetric m)
{
  const Symmetric result = {m.xx * m.xx + m.xy * m.xy + m.xz * m.xz,
                            m.xx * m.xy + m.xy * m.yy + m.xz * m.yz,
                            m.xx * m.xz + m.xy * m.yz + m.xz * m.zz,
                            m.xy * m.xy + m.yy * m.yy + m.yz * m.yz,
                            m.xy * m.xz + m.yy * m.yz + m.yz * m.zz,
                            m.xz * m.xz + m.yz * m.yz + m.zz * m.zz};
  return result;
}

// The power 2^20 tells eigenvalues apart as far as rounding does. Four squarings take a trace of 1 to 1e-7 at least.
#define ROUNDS_OF_SQUARING 5

// Of length one and of either sign; NaN where the second least eigenvalue is no more than `noise`, and where the matrix
// is not finite. m: its trace is 1
static inline Direction least_direction(Symmetric m, lanes noise)
{
  Symmetric power = adjugate(m);
  // The sum of the eigenvalues' products two at a time.
  const lanes products = trace(power);
  for (int round = 0; round < ROUNDS_OF_SQUARING; ++round)
    power = squared(squared(squared(squared(scaled(power, 1 / trace(power))))));
  const lanes largest = fmax(power.xx, fmax(power.yy, power.zz));
  const Direction column = {power.xx == largest   ? power.xx
                            : power.yy == largest ? power.xy
                                                  : power.xz,
                            power.xx == largest   ? power.xy
                            : power.yy == largest ? power.yy
                                                  : power.yz,
                            power.xx == largest   ? power.xz
                            : power.yy == largest ? power.yz
                                                  : power.zz};
  const lanes shorter = 1 / sqrt(column.x * column.x + column.y * column.y + column.z * column.z);
  const Direction d = {column.x * shorter, column.y * shorter, column.z * shorter};
  const lanes least =
      d.x * (m.xx * d.x + 2 * (m.xy * d.y + m.xz * d.z)) + d.y * (m.yy * d.y + 2 * m.yz * d.z) + m.zz * d.z * d.z;
  const lanes others = 1 - least, product = products - least * others;
  const lanes middle = 2 * product / (others + sqrt(fmax(others * others - 4 * product, (lanes)(0))));
  const Direction result = {
      middle > noise ? d.x : (lanes)(NAN), middle > noise ? d.y : (lanes)(NAN), middle > noise ? d.z : (lanes)(NAN)};
  return result;
}

#endif
