#include "cloud_harness.h"

#include "cli/vtk.h"

using namespace pcl_gpu_icp;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string path = "fuzz.vtk";
  cli::Cloud cloud;
  if (!fuzz::reads(path, [&] { cloud = cli::readVtk(path, fuzz::textOf(data, size)); }))
    return 0;
  fuzz::requireSound(cloud);
  fuzz::require(cloud.data.fields.size() == 3, "it has x, y and z");
  fuzz::require(cli::coordinates(cloud, path).points.size() <= size / 5 + 1, "a point takes five bytes at least");
  return 0;
}
