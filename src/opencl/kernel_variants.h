#pragma once

#include "cl.h"

#include <pcl_gpu_icp/device.h>

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <string>

namespace pcl_gpu_icp::opencl {

/// Keeps launches of one kernel and local size apart where PoCL would count the uses of another variant of it.
///
/// PoCL (3.1 to 5.0 at least) makes a new variant of a kernel for each launch that is wider than any before, and for
/// the first with an offset. Launches in flight use what fits, but the end of each is counted at the variant used last,
/// and the process aborts when that one's count is zero. So a launch that needs a new variant runs alone.
class KernelVariants {
public:
  /// Those of a kernel, named with its program's options, and a local size on a device; null where launches need not be
  /// kept apart. PoCL counts for the whole process, whatever the context.
  static KernelVariants* of(const DeviceInfo& device, const std::string& kernel, const cl::NDRange& local);

  /// Joins the launches in flight, if the variant used last serves this one too.
  /// \param width of the widest dimension, in work-items
  bool tryJoin(std::size_t width, bool has_offset);

  /// A launch that joined has finished.
  void leave();

  /// Waits until no launch is in flight; none may join until endAlone(). The caller has none itself.
  void beginAlone(std::size_t width, bool has_offset);
  void endAlone();

private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t in_flight_ = 0;
  bool alone_ = false;
  std::size_t width_ = 0; ///< of the variant used last,
  bool offset_ = false;   ///< and whether it serves launches with an offset
};

} // namespace pcl_gpu_icp::opencl
