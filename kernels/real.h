// The type sums and matrices are kept in (build option -DREAL_IS_DOUBLE), and the vectors that fill 64 bytes of it.
#ifndef PCL_GPU_ICP_REAL_H
#define PCL_GPU_ICP_REAL_H

// On a CPU without AVX-512 clang says that functions which take 16-wide vectors by value are called in another way than
// on one with it. Here caller and callee are always compiled together.
#ifdef __clang__
#if __has_warning("-Wpsabi")
#pragma clang diagnostic ignored "-Wpsabi"
#endif
#endif

#ifdef REAL_IS_DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double real;
typedef double4 real4;
typedef double8 real8;
typedef double8 real_lanes;
typedef double16 real_sums;
#define LANES 8
#define load_lanes(p) convert_double8(vload8(0, p))
#define store_lanes(v, p) vstore8(convert_float8(v), 0, p)
#define lanes_of(v) convert_double16(v)
#define floats_of(v) convert_float16(v)
#define REAL_EPSILON DBL_EPSILON
#else
typedef float real;
typedef float4 real4;
typedef float8 real8;
typedef float16 real_lanes;
typedef float16 real_sums;
#define LANES 16
#define load_lanes(p) vload16(0, p)
#define store_lanes(v, p) vstore16(v, 0, p)
#define lanes_of(v) (v)
#define floats_of(v) (v)
#define REAL_EPSILON FLT_EPSILON
#endif

#include "layout.h"

// The lanes' sum, always in the same order. Lane by lane: oclgrind takes swizzles of 16 lanes for uninitialised.
static inline real sum_lanes(real_lanes v)
{
#if LANES == 16
  return (((v.s0 + v.s4) + (v.s8 + v.sc)) + ((v.s1 + v.s5) + (v.s9 + v.sd))) +
         (((v.s2 + v.s6) + (v.sa + v.se)) + ((v.s3 + v.s7) + (v.sb + v.sf)));
#else
  return ((v.s0 + v.s4) + (v.s1 + v.s5)) + ((v.s2 + v.s6) + (v.s3 + v.s7));
#endif
}

#endif
