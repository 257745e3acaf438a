#include "cloud_harness.h"
#include "cloud_text.h"
#include "random_cloud.h"

#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include <cmath>
#include <sstream>
#include <string_view>
#include <sys/mman.h>
#include <unistd.h>

using namespace pcl_gpu_icp;

namespace {

cli::Cloud readByPcl(const std::string& pcd)
{
  cli::Cloud cloud;
  std::istringstream stream(pcd);
  int version = 0, encoding = 0;
  unsigned body = 0;
  pcl::PCDReader reader;
  fuzz::require(reader.readHeader(
                    stream, cloud.data, cloud.sensor_origin, cloud.sensor_orientation, version, encoding, body) == 0,
                "PCL reads the header");
  stream.seekg(body);
  const auto* bytes = reinterpret_cast<const unsigned char*>(pcd.data());
  fuzz::require((encoding == 0 ? reader.readBodyASCII(stream, cloud.data, version)
                               : reader.readBodyBinary(bytes, cloud.data, version, encoding == 2, body)) == 0,
                "PCL reads the body");
  return cloud;
}

/// PCL reads PLY from files only.
cli::Cloud readPlyByPcl(const std::string& ply)
{
  static const int file = memfd_create("fuzz.ply", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(file);
  fuzz::require(ftruncate(file, 0) == 0 && pwrite(file, ply.data(), ply.size(), 0) == static_cast<ssize_t>(ply.size()),
                "memory for a file");
  cli::Cloud cloud;
  int version = 0;
  fuzz::require(pcl::PLYReader().read(path, cloud.data, cloud.sensor_origin, cloud.sensor_orientation, version) == 0,
                "PCL reads the PLY file");
  return cloud;
}

/// PCL goes on with the header in the data where these begin as one of its lines does.
bool readsOnAsHeader(const std::string& pcd)
{
  const std::string_view data = std::string_view(pcd).substr(pcd.find("\nDATA ") + 1);
  const std::string_view after = data.substr(data.find('\n'));
  for (const char* word :
       {"FIELDS", "COLUMNS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA"})
    if (after.find(word) != std::string_view::npos)
      return true;
  return false;
}

void requireSamePcd(const std::string& pcd)
{
  if (readsOnAsHeader(pcd))
    return;
  const cli::Cloud ours = cli::readPcd("ours.pcd", pcd), theirs = readByPcl(pcd);
  fuzz::requireSameValues(ours, theirs);
  fuzz::require(ours.sensor_origin == theirs.sensor_origin &&
                    ours.sensor_orientation.coeffs() == theirs.sensor_orientation.coeffs(),
                "the same viewpoint");
}

/// What PCL 1.13 reads rightly from ASCII: it reads everything as a double, so that integers lose what is beyond 53
/// bits.
void makePlain(cli::Cloud& cloud)
{
  fuzz::forEachValue(cloud, [&](const pcl::PCLPointField& field, std::size_t at) {
    std::uint8_t* place = cloud.data.data.data() + at;
    fuzz::visitValue(field.datatype, place, [place](auto value) {
      if constexpr (std::is_floating_point_v<decltype(value)>) {
        if (!std::isnormal(value))
          value = 0;
      }
      else if constexpr (sizeof value == 8) {
        value >>= 11;
      }
      std::memcpy(place, &value, sizeof value);
    });
  });
}

} // namespace

/// Our readers and PCL's read the same from files that a program could have written.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  fuzz::Bytes bytes(data, size);
  cli::Cloud cloud = fuzz::randomCloud(bytes);
  requireSamePcd(fuzz::binaryPcd(cloud));
  requireSamePcd(cli::writePcd(cloud));
  std::string ply;
  try {
    ply = cli::writePly(cloud);
  } catch (const cli::Failure&) { // it has 8-byte integers
  }
  if (!ply.empty())
    fuzz::requireSameValues(cli::readPly("ours.ply", ply), readPlyByPcl(ply));
  makePlain(cloud);
  requireSamePcd(fuzz::asciiPcd(cloud));
  return 0;
}
