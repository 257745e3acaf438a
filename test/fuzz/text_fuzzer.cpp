#include "cloud_harness.h"

#include "cli/text_cloud.h"

using namespace pcl_gpu_icp;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string path = "fuzz.xyz";
  const auto cloud = fuzz::read(path, cli::readTextCloud, data, size);
  if (!cloud)
    return 0;
  fuzz::require(cloud->data.fields.size() == 3, "a text has x, y and z");
  fuzz::require(cli::coordinates(*cloud, path).points.size() <= size / 5 + 1,
                "a point takes five bytes and a line end");
  return 0;
}
