#pragma once

#include "cli/cloud.h"

#include <charconv>
#include <string>

namespace pcl_gpu_icp::fuzz {

/// Calls back with a value as its own type.
template <typename Visit>
void visitValue(std::uint8_t type, const std::uint8_t* at, Visit visit)
{
  const auto as = [at, &visit](auto value) {
    std::memcpy(&value, at, sizeof value);
    visit(value);
  };
  using Field = pcl::PCLPointField;
  if (type == Field::INT8)
    as(std::int8_t());
  else if (type == Field::UINT8)
    as(std::uint8_t());
  else if (type == Field::INT16)
    as(std::int16_t());
  else if (type == Field::UINT16)
    as(std::uint16_t());
  else if (type == Field::INT32)
    as(std::int32_t());
  else if (type == Field::UINT32)
    as(std::uint32_t());
  else if (type == Field::FLOAT32)
    as(float());
  else if (type == Field::FLOAT64)
    as(double());
  else if (type == cli::fieldType('I', 8))
    as(std::int64_t());
  else
    as(std::uint64_t());
}

/// Calls back with each value of a cloud, point by point: its field, its place in the point and the point.
template <typename Visit>
void forEachValue(const cli::Cloud& cloud, Visit visit)
{
  for (std::size_t point = 0; point < cloud.size(); ++point)
    for (const auto& field : cloud.data.fields)
      for (std::uint32_t i = 0; i < field.count; ++i)
        visit(field, point * cloud.data.point_step + field.offset + i * cli::fieldSize(field.datatype));
}

inline std::string pcdHeader(const cli::Cloud& cloud, const std::string& encoding)
{
  std::string names, sizes, types, counts;
  for (const auto& field : cloud.data.fields) {
    names += " " + field.name;
    sizes += " " + std::to_string(cli::fieldSize(field.datatype));
    visitValue(field.datatype, cloud.data.data.data(), [&types](auto value) {
      types += std::is_floating_point_v<decltype(value)> ? " F" : std::is_signed_v<decltype(value)> ? " I" : " U";
    });
    counts += " " + std::to_string(field.count);
  }
  const auto number = [](float value) { return " " + std::to_string(value); };
  const auto& origin = cloud.sensor_origin;
  const auto& turn = cloud.sensor_orientation;
  return "VERSION 0.7\nFIELDS" + names + "\nSIZE" + sizes + "\nTYPE" + types + "\nCOUNT" + counts + "\nWIDTH " +
         std::to_string(cloud.data.width) + "\nHEIGHT " + std::to_string(cloud.data.height) + "\nVIEWPOINT" +
         number(origin[0]) + number(origin[1]) + number(origin[2]) + number(turn.w()) + number(turn.x()) +
         number(turn.y()) + number(turn.z()) + "\nPOINTS " + std::to_string(cloud.size()) + "\nDATA " + encoding + "\n";
}

inline std::string binaryPcd(const cli::Cloud& cloud)
{
  return pcdHeader(cloud, "binary") + std::string(cloud.data.data.begin(), cloud.data.data.end());
}

/// With as many digits as it takes.
inline std::string asciiPcd(const cli::Cloud& cloud)
{
  std::string text = pcdHeader(cloud, "ascii");
  forEachValue(cloud, [&](const pcl::PCLPointField& field, std::size_t at) {
    visitValue(field.datatype, cloud.data.data.data() + at, [&text](auto value) {
      char digits[64];
      text.append(digits, std::to_chars(std::begin(digits), std::end(digits), value).ptr) += ' ';
    });
    const auto& last = cloud.data.fields.back();
    if (at % cloud.data.point_step == last.offset + (last.count - 1) * cli::fieldSize(last.datatype))
      text += '\n';
  });
  return text;
}

/// Text has one NaN, and a NaN's bits are not its value.
inline void makeNansPlain(cli::Cloud& cloud)
{
  forEachValue(cloud, [&](const pcl::PCLPointField& field, std::size_t at) {
    std::uint8_t* place = cloud.data.data.data() + at;
    visitValue(field.datatype, place, [place](auto value) {
      if (value != value) {
        value = std::numeric_limits<decltype(value)>::quiet_NaN();
        std::memcpy(place, &value, sizeof value);
      }
    });
  });
}

} // namespace pcl_gpu_icp::fuzz
