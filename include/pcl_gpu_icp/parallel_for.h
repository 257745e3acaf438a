#pragma once

#include <pcl_gpu_icp/export.h>

#include <cstddef>
#include <functional>

namespace pcl_gpu_icp {

/// Calls body(begin, end) for ranges of `range_size` that together cover [0, count), from at most `threads` host
/// threads, this one included. A thread is started for every two ranges at most, so small counts stay on this thread.
/// The first exception of a body is rethrown here.
PCL_GPU_ICP_API void parallelFor(std::size_t count,
                                 std::size_t range_size,
                                 unsigned threads,
                                 const std::function<void(std::size_t begin, std::size_t end)>& body);

/// `threads`, or the number of cores when it is 0.
PCL_GPU_ICP_API unsigned effectiveThreads(unsigned threads);

} // namespace pcl_gpu_icp
