#include "cli/cloud.h"

#include "cli/input_file.h"
#include "cli/number.h"

#include <pcl/pcl_config.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>

namespace pcl_gpu_icp::cli {
namespace {

using Field = pcl::PCLPointField;

template <typename Number>
bool store(std::string_view text, std::uint8_t* to)
{
  Number value{};
  if constexpr (std::is_floating_point_v<Number>) {
    const auto parsed = parseNumber<double>(text);
    if (!parsed)
      return false;
    value = static_cast<Number>(*parsed);
  }
  else if (const auto parsed = parseNumber<Number>(text)) {
    value = *parsed;
  }
  else {
    // Some writers put a decimal point into every column.
    const auto real = parseNumber<double>(text);
    constexpr double least = std::numeric_limits<Number>::min();
    constexpr auto most = static_cast<double>(std::numeric_limits<Number>::max());
    if (!real || !(*real >= least && *real <= most) || sizeof(Number) > 4)
      return false;
    value = static_cast<Number>(*real);
    if (value != *real)
      return false;
  }
  std::memcpy(to, &value, sizeof value);
  return true;
}

const Field* findField(const Cloud& cloud, const std::string& name)
{
  for (const Field& field : cloud.data.fields)
    if (field.name == name)
      return &field;
  return nullptr;
}

bool isReal(const Field& field)
{
  return (field.datatype == Field::FLOAT32 || field.datatype == Field::FLOAT64) && field.count == 1;
}

} // namespace

void Cloud::setSize(std::size_t width, std::size_t height, const std::string& path)
{
  if (width == 0 || height == 0)
    throw inputFailure(path, "has no points");
  constexpr std::size_t most_bytes = std::numeric_limits<std::uint32_t>::max();
  if (width > most_bytes / height / data.point_step)
    throw inputFailure(path, std::to_string(width) + " x " + std::to_string(height) + " points are more than 4 GiB");
  data.width = static_cast<std::uint32_t>(width);
  data.height = static_cast<std::uint32_t>(height);
  data.row_step = data.width * data.point_step;
}

std::uint8_t fieldType(char kind, std::size_t size)
{
  const bool is_signed = kind == 'I';
  if (kind == 'F')
    return size == 4 ? Field::FLOAT32 : size == 8 ? Field::FLOAT64 : 0;
  if (kind != 'I' && kind != 'U')
    return 0;
  switch (size) {
  case 1:
    return is_signed ? Field::INT8 : Field::UINT8;
  case 2:
    return is_signed ? Field::INT16 : Field::UINT16;
  case 4:
    return is_signed ? Field::INT32 : Field::UINT32;
#if PCL_VERSION_COMPARE(>=, 1, 13, 0)
  case 8:
    return is_signed ? Field::INT64 : Field::UINT64;
#endif
  }
  return 0;
}

std::size_t fieldSize(std::uint8_t type)
{
  switch (type) {
  case Field::INT8:
  case Field::UINT8:
    return 1;
  case Field::INT16:
  case Field::UINT16:
    return 2;
  case Field::INT32:
  case Field::UINT32:
  case Field::FLOAT32:
    return 4;
  }
  return 8;
}

void addField(pcl::PCLPointCloud2& cloud, const std::string& name, std::uint8_t type, std::uint32_t count)
{
  Field field;
  field.name = name;
  field.offset = cloud.point_step;
  field.datatype = type;
  field.count = count;
  cloud.fields.push_back(field);
  cloud.point_step += count * static_cast<std::uint32_t>(fieldSize(type));
}

bool storeNumber(std::string_view text, std::uint8_t type, std::uint8_t* to)
{
  switch (type) {
  case Field::INT8:
    return store<std::int8_t>(text, to);
  case Field::UINT8:
    return store<std::uint8_t>(text, to);
  case Field::INT16:
    return store<std::int16_t>(text, to);
  case Field::UINT16:
    return store<std::uint16_t>(text, to);
  case Field::INT32:
    return store<std::int32_t>(text, to);
  case Field::UINT32:
    return store<std::uint32_t>(text, to);
#if PCL_VERSION_COMPARE(>=, 1, 13, 0)
  case Field::INT64:
    return store<std::int64_t>(text, to);
  case Field::UINT64:
    return store<std::uint64_t>(text, to);
#endif
  case Field::FLOAT32:
    return store<float>(text, to);
  }
  return store<double>(text, to);
}

std::optional<VectorField> VectorField::find(const Cloud& cloud, const std::array<std::string, 3>& names)
{
  VectorField result;
  for (int axis = 0; axis < 3; ++axis) {
    const Field* field = findField(cloud, names[axis]);
    if (!field || !isReal(*field))
      return std::nullopt;
    result.fields_[axis] = *field;
  }
  return result;
}

std::array<double, 3> VectorField::get(const std::uint8_t* point) const
{
  std::array<double, 3> value;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint8_t* from = point + fields_[axis].offset;
    if (fields_[axis].datatype == Field::FLOAT64) {
      std::memcpy(&value[axis], from, sizeof(double));
      continue;
    }
    float narrow;
    std::memcpy(&narrow, from, sizeof narrow);
    value[axis] = narrow;
  }
  return value;
}

void VectorField::set(std::uint8_t* point, const std::array<double, 3>& value) const
{
  for (int axis = 0; axis < 3; ++axis) {
    std::uint8_t* to = point + fields_[axis].offset;
    if (fields_[axis].datatype == Field::FLOAT64) {
      std::memcpy(to, &value[axis], sizeof(double));
      continue;
    }
    const auto narrow = static_cast<float>(value[axis]);
    std::memcpy(to, &narrow, sizeof narrow);
  }
}

bool VectorField::hasDouble() const
{
  return std::any_of(
      fields_.begin(), fields_.end(), [](const Field& field) { return field.datatype == Field::FLOAT64; });
}

Coordinates coordinates(const Cloud& cloud, const std::string& path)
{
  for (const char* name : {"x", "y", "z"}) {
    const Field* field = findField(cloud, name);
    if (!field)
      throw inputFailure(path, std::string("has no field ") + name);
    if (!isReal(*field))
      throw inputFailure(path, std::string("field ") + name + " is not one float or double per point");
  }
  const auto xyz = VectorField::find(cloud, {"x", "y", "z"});
  Coordinates result;
  result.from_double = xyz->hasDouble();
  result.points.reserve(cloud.size());
  const std::uint8_t* point = cloud.data.data.data();
  for (std::size_t i = 0; i < cloud.size(); ++i, point += cloud.data.point_step)
    result.points.push_back(xyz->get(point));
  return result;
}

} // namespace pcl_gpu_icp::cli
