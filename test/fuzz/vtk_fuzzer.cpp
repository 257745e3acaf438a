#include "cloud_harness.h"

#include "cli/vtk.h"

using namespace pcl_gpu_icp;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string path = "fuzz.vtk";
  const auto cloud = fuzz::read(path, cli::readVtk, data, size);
  if (!cloud)
    return 0;
  fuzz::require(cloud->data.fields.size() == 3, "it has x, y and z");
  fuzz::require(cli::coordinates(*cloud, path).points.size() <= size / 5 + 1, "a point takes five bytes at least");
  return 0;
}
