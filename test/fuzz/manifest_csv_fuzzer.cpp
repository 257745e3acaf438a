#include "manifest_harness.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  pcl_gpu_icp::fuzz::readManifest("folder/fuzz.csv", pcl_gpu_icp::fuzz::textOf(data, size));
  return 0;
}
