#include "cloud_harness.h"

using namespace pcl_gpu_icp;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string path = "fuzz.ply";
  cli::Cloud cloud;
  if (!fuzz::reads(path, [&] { cloud = cli::readPly(path, fuzz::textOf(data, size)); }))
    return 0;
  fuzz::requireSound(cloud);
  fuzz::reads(path, [&] { cli::coordinates(cloud, path); });
  return 0;
}
