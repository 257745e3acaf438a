#include "cloud_harness.h"
#include "cloud_text.h"
#include "random_cloud.h"

#include <limits>

using namespace pcl_gpu_icp;

namespace {

const pcl::PCLPointField* fieldNamed(const cli::Cloud& cloud, const std::string& name)
{
  for (const auto& field : cloud.data.fields)
    if (field.name == name)
      return &field;
  return nullptr;
}

/// PLY has no counts, and of a colour three bytes.
void requireSameAsPly(const cli::Cloud& cloud)
{
  std::string content;
  try {
    content = cli::writePly(cloud);
  } catch (const cli::Failure& failure) {
    fuzz::require(failure.code() == cli::ExitCode::Output, "what PLY cannot hold is refused as an output");
    return;
  }
  const cli::Cloud again = cli::readPly("written.ply", content);
  fuzz::requireSound(again);
  fuzz::require(again.data.width == cloud.data.width && again.data.height == cloud.data.height, "the same size");
  for (const auto& field : cloud.data.fields)
    for (std::uint32_t i = 0; i < field.count; ++i) {
      const bool is_colour = field.name == "rgb";
      const std::size_t bytes = is_colour ? 3 : cli::fieldSize(field.datatype);
      const auto* read = fieldNamed(again, field.count == 1 ? field.name : field.name + "_" + std::to_string(i));
      fuzz::require(read && (is_colour || read->datatype == field.datatype), "a field under its name");
      for (std::size_t point = 0; point < cloud.size(); ++point)
        fuzz::require(std::memcmp(cloud.data.data.data() + point * cloud.data.point_step + field.offset + i * bytes,
                                  again.data.data.data() + point * again.data.point_step + read->offset,
                                  bytes) == 0,
                      "the same values");
    }
}

} // namespace

/// What is written is read back, bit for bit.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  fuzz::Bytes bytes(data, size);
  cli::Cloud cloud = fuzz::randomCloud(bytes);
  fuzz::requireSameAsPcd(cloud);
  requireSameAsPly(cloud);
  fuzz::requireSameValues(cloud, cli::readPcd("binary.pcd", fuzz::binaryPcd(cloud)));
  fuzz::makeNansPlain(cloud);
  fuzz::requireSameValues(cloud, cli::readPcd("ascii.pcd", fuzz::asciiPcd(cloud)));
  return 0;
}
