#pragma once

#include "bytes.h"

#include "cli/cloud.h"

#include <array>

namespace pcl_gpu_icp::fuzz {

/// A cloud that a program could have made: x, y, z and up to five other fields of any type and count.
inline cli::Cloud randomCloud(Bytes& bytes)
{
  using Field = pcl::PCLPointField;
  constexpr std::array<const char*, 5> others = {"normal_x", "reflectivity", "label", "t", "rgb"};
  const std::array<std::uint8_t, 10> types = {Field::INT8,
                                              Field::UINT8,
                                              Field::INT16,
                                              Field::UINT16,
                                              Field::INT32,
                                              Field::UINT32,
                                              Field::FLOAT32,
                                              Field::FLOAT64,
                                              cli::fieldType('I', 8),
                                              cli::fieldType('U', 8)};
  cli::Cloud cloud;
  const std::uint8_t coordinate = bytes.flag() ? Field::FLOAT64 : Field::FLOAT32;
  for (const char* name : {"x", "y", "z"})
    cli::addField(cloud, "random", name, coordinate);
  const std::uint8_t chosen = bytes.byte();
  for (std::size_t i = 0; i < others.size(); ++i)
    if ((chosen >> i & 1) != 0) {
      const std::uint8_t type = types[bytes.upTo(types.size() - 1)];
      const bool is_colour = std::string_view(others[i]) == "rgb";
      const bool is_single = is_colour || i == 0; // PLY's names of normals are PCL's only for single ones
      cli::addField(cloud,
                    "random",
                    others[i],
                    is_colour ? std::uint8_t(Field::FLOAT32) : type,
                    is_single ? 1 : 1 + bytes.upTo(2));
    }
  for (int axis = 0; axis < 3; ++axis)
    cloud.sensor_origin[axis] = static_cast<float>(bytes.byte()) / 8;
  cloud.sensor_orientation =
      Eigen::Quaternionf(1, static_cast<float>(bytes.byte()), 0, static_cast<float>(bytes.byte()));
  cloud.has_pose = true;
  const std::size_t width = 1 + bytes.upTo(7);
  cloud.setSize(width, 1 + bytes.upTo(2), "random");
  cloud.data.data.resize(cloud.size() * cloud.data.point_step);
  bytes.fill(cloud.data.data.data(), cloud.data.data.size());
  return cloud;
}

} // namespace pcl_gpu_icp::fuzz
