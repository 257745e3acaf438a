#include "cloud_harness.h"

#include "cli/text_cloud.h"

using namespace pcl_gpu_icp;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string path = "fuzz.xyz";
  cli::Cloud cloud;
  if (!fuzz::reads(path, [&] { cloud = cli::readTextCloud(path, fuzz::textOf(data, size)); }))
    return 0;
  fuzz::requireSound(cloud);
  fuzz::require(cloud.data.fields.size() == 3, "a text has x, y and z");
  fuzz::require(cli::coordinates(cloud, path).points.size() <= size / 5 + 1, "a point takes five bytes and a line end");
  return 0;
}
