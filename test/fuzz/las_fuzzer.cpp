#include "cloud_harness.h"

#include "cli/las.h"

using namespace pcl_gpu_icp;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string path = "fuzz.las";
  const auto cloud = fuzz::read(path, cli::readLas, data, size);
  if (!cloud)
    return 0;
  fuzz::require(cloud->size() <= size / 20, "a point takes twenty bytes at least");
  for (const auto& point : cli::coordinates(*cloud, path).points)
    for (const double coordinate : point)
      fuzz::require(coordinate == coordinate, "scales and offsets are finite");
  return 0;
}
