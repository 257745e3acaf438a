// The type sums and matrices are kept in (build option -DREAL_IS_DOUBLE), and the vectors that fill 64 bytes of it.
#ifndef PCL_GPU_ICP_REAL_H
#define PCL_GPU_ICP_REAL_H

#ifdef REAL_IS_DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double real;
typedef double4 real4;
typedef double8 real_lanes;
typedef double16 real_sums;
#define LANES 8
#define load_lanes(p) convert_double8(vload8(0, p))
#define REAL_EPSILON DBL_EPSILON
#else
typedef float real;
typedef float4 real4;
typedef float16 real_lanes;
typedef float16 real_sums;
#define LANES 16
#define load_lanes(p) vload16(0, p)
#define REAL_EPSILON FLT_EPSILON
#endif

#include "layout.h"

// The lanes' sum, always in the same order.
static inline real sum_lanes(real_lanes v)
{
#if LANES == 16
  const real4 a = (v.s0123 + v.s4567) + (v.s89ab + v.scdef);
#else
  const real4 a = v.s0123 + v.s4567;
#endif
  return (a.x + a.y) + (a.z + a.w);
}

#endif
