#include "cli/las.h"

#include "cli/input_file.h"

#include "report/format.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>

namespace pcl_gpu_icp::cli {
namespace {

constexpr std::string_view magic = "LASF";

// Bytes of a record of each format, without what a program adds.
constexpr std::size_t least_record[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
constexpr unsigned first_wide_format = 6; // formats from here on have the classification a byte later

/// Little-endian, as x86 and ARM are.
template <typename T>
T valueAt(std::string_view content, std::size_t place)
{
  T value;
  std::memcpy(&value, content.data() + place, sizeof value);
  return value;
}

struct Header {
  std::size_t data;   ///< where the first record is
  unsigned format;    ///< of the records
  std::size_t record; ///< bytes of each
  std::uint64_t points;
  std::array<double, 3> scale, offset; ///< of x, y and z, which are integers
};

Header readHeader(const std::string& path, std::string_view content)
{
  constexpr std::size_t shortest = 227, of_1_4 = 375;
  constexpr unsigned compressed = 0x80, format_bits = 0x3F;
  if (content.size() < shortest)
    throw inputFailure(path,
                       report::format("its %zu bytes are fewer than the header of a LAS file has", content.size()));
  const unsigned minor = valueAt<std::uint8_t>(content, 25);
  const auto format = valueAt<std::uint8_t>(content, 104);
  Header header{valueAt<std::uint32_t>(content, 96),
                format & format_bits,
                valueAt<std::uint16_t>(content, 105),
                valueAt<std::uint32_t>(content, 107),
                {},
                {}};
  if (format & compressed)
    throw inputFailure(path,
                       "is a LAZ file, which is compressed: laspy decompress " + shellWord(path) +
                           " (pip install 'laspy[cli,lazrs]')");
  if (header.format >= std::size(least_record))
    throw inputFailure(path, report::format("has points of the format %u; 0 to 10 are read", header.format));
  if (header.record < least_record[header.format])
    throw inputFailure(path,
                       report::format("says that a point of the format %u has %zu bytes, and it has %zu at least",
                                      header.format,
                                      header.record,
                                      least_record[header.format]));
  if (minor >= 4 && content.size() >= of_1_4 && valueAt<std::uint16_t>(content, 94) >= of_1_4)
    header.points = std::max(header.points, valueAt<std::uint64_t>(content, 247));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.scale[axis] = valueAt<double>(content, 131 + 8 * axis);
    header.offset[axis] = valueAt<double>(content, 155 + 8 * axis);
    if (!(std::isfinite(header.scale[axis]) && header.scale[axis] != 0 && std::isfinite(header.offset[axis])))
      throw inputFailure(path,
                         report::format("the %c of its points has the scale %g and the offset %g",
                                        "xyz"[axis],
                                        header.scale[axis],
                                        header.offset[axis]));
  }
  const bool has_records = header.data >= shortest && header.data <= content.size();
  const std::size_t there = has_records ? (content.size() - header.data) / header.record : 0;
  if (header.points > there)
    throw inputFailure(path,
                       report::format("its header promises %llu points, and the file has %zu",
                                      static_cast<unsigned long long>(header.points),
                                      there));
  return header;
}

} // namespace

bool isLas(std::string_view content) { return content.substr(0, magic.size()) == magic; }

Cloud readLas(const std::string& path, std::string_view content)
{
  const Header header = readHeader(path, content);
  Cloud cloud;
  addCoordinates(cloud, path, pcl::PCLPointField::FLOAT64);
  addField(cloud, path, "intensity", pcl::PCLPointField::UINT16);
  addField(cloud, path, "classification", pcl::PCLPointField::UINT8);
  cloud.setSize(header.points, 1, path);
  cloud.data.data.resize(cloud.size() * cloud.data.point_step);
  const auto& fields = cloud.data.fields;
  constexpr std::size_t intensity = 12; // in a record
  const std::size_t classification = header.format < first_wide_format ? 15 : 16;
  std::uint8_t* to = cloud.data.data.data();
  for (std::size_t point = 0; point < header.points; ++point, to += cloud.data.point_step) {
    const std::string_view record = content.substr(header.data + point * header.record, header.record);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double value = valueAt<std::int32_t>(record, 4 * axis) * header.scale[axis] + header.offset[axis];
      std::memcpy(to + fields[axis].offset, &value, sizeof value);
    }
    std::memcpy(to + fields[3].offset, record.data() + intensity, sizeof(std::uint16_t));
    to[fields[4].offset] = static_cast<std::uint8_t>(record[classification]);
  }
  return cloud;
}

} // namespace pcl_gpu_icp::cli
