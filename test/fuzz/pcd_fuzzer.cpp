#include "cloud_harness.h"

using namespace pcl_gpu_icp;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string path = "fuzz.pcd";
  const auto cloud = fuzz::read(path, cli::readPcd, data, size);
  if (!cloud)
    return 0;
  fuzz::reads(path, [&] { cli::coordinates(*cloud, path); });
  return 0;
}
