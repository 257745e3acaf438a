#pragma once

#include "harness.h"

#include "cli/cloud.h"
#include "cli/failure.h"
#include "cli/pcd.h"
#include "cli/ply.h"

#include <optional>

namespace pcl_gpu_icp::fuzz {

/// What every reader of clouds must give.
inline void requireSound(const cli::Cloud& cloud)
{
  const auto& data = cloud.data;
  require(cloud.size() > 0, "a cloud that was read has points");
  require(data.data.size() == cloud.size() * data.point_step, "the data are as large as the points");
  for (const auto& field : data.fields)
    require(std::size_t(field.offset) + cli::fieldSize(field.datatype) * field.count <= data.point_step,
            "every field lies within the point");
}

/// What a reader makes of an input; nothing where it refuses it.
inline std::optional<cli::Cloud> read(const std::string& path,
                                      cli::Cloud (*reader)(const std::string&, std::string_view),
                                      const std::uint8_t* data,
                                      std::size_t size)
{
  cli::Cloud cloud;
  if (!reads(path, [&] { cloud = reader(path, textOf(data, size)); }))
    return std::nullopt;
  requireSound(cloud);
  return cloud;
}

inline void requireSameFields(const cli::Cloud& a, const cli::Cloud& b)
{
  require(a.data.fields.size() == b.data.fields.size(), "as many fields");
  for (std::size_t i = 0; i < a.data.fields.size(); ++i) {
    const auto &one = a.data.fields[i], &other = b.data.fields[i];
    if (one.name != other.name || one.datatype != other.datatype || one.count != other.count)
      require(false, ("field " + one.name + " is not field " + other.name + ", or of another type").c_str());
  }
}

/// Every value of one cloud is that of the other, to the bit, wherever it lies in the point.
inline void requireSameValues(const cli::Cloud& a, const cli::Cloud& b)
{
  require(a.data.width == b.data.width && a.data.height == b.data.height, "the same size");
  requireSameFields(a, b);
  for (std::size_t i = 0; i < a.data.fields.size(); ++i) {
    const auto &one = a.data.fields[i], &other = b.data.fields[i];
    const std::size_t bytes = cli::fieldSize(one.datatype) * one.count;
    for (std::size_t point = 0; point < a.size(); ++point)
      if (std::memcmp(a.data.data.data() + point * a.data.point_step + one.offset,
                      b.data.data.data() + point * b.data.point_step + other.offset,
                      bytes) != 0)
        require(false, ("field " + one.name + " is not the same").c_str());
  }
}

/// What is written is read back.
inline void requireSameAsPcd(const cli::Cloud& cloud)
{
  const cli::Cloud again = cli::readPcd("written.pcd", cli::writePcd(cloud));
  requireSound(again);
  requireSameValues(cloud, again);
  const auto bits = [](const cli::Cloud& of) {
    std::array<float, 7> viewpoint{};
    std::memcpy(viewpoint.data(), of.sensor_origin.data(), 3 * sizeof(float));
    std::memcpy(viewpoint.data() + 3, of.sensor_orientation.coeffs().data(), 4 * sizeof(float));
    return viewpoint;
  };
  const auto one = bits(cloud), other = bits(again);
  for (std::size_t i = 0; i < one.size(); ++i)
    require(one[i] == other[i] || (one[i] != one[i] && other[i] != other[i]), "the same viewpoint");
}

} // namespace pcl_gpu_icp::fuzz
