#pragma once

// FLANN's allocator of nodes, which goes on with a null pointer where malloc() gives it one: here it throws. To be
// included before anything else of FLANN. Nothing of FLANN that is instantiated here is visible outside of the library.
#include <new>
// The headers that FLANN's includes, before malloc has another name.
#include <stdio.h>  // NOLINT(modernize-deprecated-headers)
#include <stdlib.h> // NOLINT(modernize-deprecated-headers)

inline void* pclGpuIcpMallocOrThrow(std::size_t bytes)
{
  void* const memory = std::malloc(bytes);
  if (!memory)
    throw std::bad_alloc();
  return memory;
}

#ifdef FLANN_ALLOCATOR_H_
#error "FLANN's allocator has been included before"
#endif
#define malloc pclGpuIcpMallocOrThrow
#include <flann/util/allocator.h>
#undef malloc
