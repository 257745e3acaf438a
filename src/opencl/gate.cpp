#include "gate.h"

#include "device_handle.h"

namespace pcl_gpu_icp::opencl {

std::unique_lock<std::mutex> enterGate()
{
  // Before the lock, which the parent may have held at fork().
  refuseAfterFork();
  static std::mutex gate;
  return std::unique_lock<std::mutex>(gate);
}

} // namespace pcl_gpu_icp::opencl
