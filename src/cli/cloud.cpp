#include "cli/cloud.h"

#include "cli/input_file.h"
#include "cli/lower_case.h"
#include "cli/number.h"

#include <pcl/pcl_config.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace pcl_gpu_icp::cli {
namespace {

using Field = pcl::PCLPointField;

/// Where every width of a row is a sum of 64-bit sizes, these keep it far from any overflow.
constexpr std::size_t most_fields = 4096;
constexpr std::size_t most_bytes_per_point = 1 << 20;

template <typename Number>
Stored storeInteger(std::string_view text, Number& value)
{
  if (const auto whole = parseNumber<Number>(text)) {
    value = *whole;
    return Stored::Exactly;
  }
  using Other = std::conditional_t<std::is_signed_v<Number>, std::make_unsigned_t<Number>, std::make_signed_t<Number>>;
  if (const auto bits = parseNumber<Other>(text)) {
    value = static_cast<Number>(*bits);
    return Stored::Nearly;
  }
  const auto real = parseReal(text);
  if (!real)
    return Stored::No;
  // Of 8-byte integers double holds the largest plus one.
  constexpr auto least = static_cast<double>(std::numeric_limits<Number>::min());
  constexpr auto most = static_cast<double>(std::numeric_limits<Number>::max());
  const double nearest = std::round(*real);
  value = std::isnan(nearest) ? 0
          : nearest <= least  ? std::numeric_limits<Number>::min()
          : nearest >= most   ? std::numeric_limits<Number>::max()
                              : static_cast<Number>(nearest);
  return static_cast<double>(value) == *real ? Stored::Exactly : Stored::Nearly;
}

float toFloat(double value)
{
  constexpr double most = std::numeric_limits<float>::max();
  constexpr float infinity = std::numeric_limits<float>::infinity();
  if (std::abs(value) <= most || std::isnan(value))
    return static_cast<float>(value);
  return value < 0 ? -infinity : infinity;
}

template <typename Number>
Stored store(std::string_view text, std::uint8_t* to)
{
  Number value{};
  Stored stored = Stored::Exactly;
  if constexpr (std::is_integral_v<Number>) {
    stored = storeInteger(text, value);
  }
  else {
    // Rounded once: what float has as its greatest is more than that to double.
    if (const auto plain = parseNumber<Number>(text))
      value = *plain;
    else if (const auto real = parseReal(text))
      value = std::is_same_v<Number, float> ? toFloat(*real) : static_cast<Number>(*real);
    else
      return Stored::No;
  }
  if (stored != Stored::No)
    std::memcpy(to, &value, sizeof value);
  return stored;
}

template <typename Number>
double load(const std::uint8_t* from)
{
  Number value;
  std::memcpy(&value, from, sizeof value);
  return static_cast<double>(value);
}

double loadNumber(const std::uint8_t* from, std::uint8_t type)
{
  switch (type) {
  case Field::INT8:
    return load<std::int8_t>(from);
  case Field::UINT8:
    return load<std::uint8_t>(from);
  case Field::INT16:
    return load<std::int16_t>(from);
  case Field::UINT16:
    return load<std::uint16_t>(from);
  case Field::INT32:
    return load<std::int32_t>(from);
  case Field::UINT32:
    return load<std::uint32_t>(from);
#if PCL_VERSION_COMPARE(>=, 1, 13, 0)
  case Field::INT64:
    return load<std::int64_t>(from);
  case Field::UINT64:
    return load<std::uint64_t>(from);
#endif
  case Field::FLOAT32:
    return load<float>(from);
  }
  return load<double>(from);
}

/// Under that name, or else in other letters.
const Field* findField(const Cloud& cloud, const std::string& name)
{
  const Field* found = nullptr;
  for (const Field& field : cloud.data.fields) {
    if (field.name == name)
      return &field;
    if (!found && lowerCase(field.name) == name)
      found = &field;
  }
  return found;
}

bool isReal(const Field& field)
{
  return (field.datatype == Field::FLOAT32 || field.datatype == Field::FLOAT64) && field.count == 1;
}

bool isCoordinate(const Cloud& cloud, const Field& field)
{
  for (const char* name : {"x", "y", "z"})
    if (findField(cloud, name) == &field)
      return true;
  return false;
}

} // namespace

void Cloud::setSize(std::size_t width, std::size_t height, const std::string& path)
{
  if (width == 0 || height == 0)
    throw inputFailure(path, "has no points");
  if (data.point_step == 0)
    throw inputFailure(path, "has points of no bytes");
  constexpr std::size_t most_bytes = std::numeric_limits<std::uint32_t>::max();
  if (width > most_bytes / height / data.point_step)
    throw inputFailure(path,
                       "its header promises " + std::to_string(width) + " x " + std::to_string(height) +
                           " points, which are more than 4 GiB");
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

char fieldKind(std::uint8_t type)
{
  for (const char kind : {'I', 'U', 'F'})
    if (fieldType(kind, fieldSize(type)) == type)
      return kind;
  return 'F';
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

void addField(Cloud& cloud, const std::string& path, const std::string& name, std::uint8_t type, std::size_t count)
{
  auto& data = cloud.data;
  if (data.fields.size() == most_fields)
    throw inputFailure(path, "its points have more than " + std::to_string(most_fields) + " fields, which is the most");
  if (count > (most_bytes_per_point - data.point_step) / fieldSize(type))
    throw inputFailure(path,
                       "field " + name + ": its points have more than " + std::to_string(most_bytes_per_point) +
                           " bytes each, which is the most");
  Field field;
  field.name = name;
  field.offset = data.point_step;
  field.datatype = type;
  field.count = static_cast<std::uint32_t>(count);
  data.fields.push_back(field);
  data.point_step += static_cast<std::uint32_t>(count * fieldSize(type));
}

void addCoordinates(Cloud& cloud, const std::string& path, std::uint8_t type)
{
  for (const char* name : {"x", "y", "z"})
    addField(cloud, path, name, type);
}

Stored storeNumber(std::string_view text, std::uint8_t type, std::uint8_t* to)
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

bool ValueStore::store(std::string_view text, std::size_t field, std::uint8_t type, std::uint8_t* to)
{
  const Field& layout = cloud_.data.fields[field];
  const Stored stored = storeNumber(text, type, to);
  if (layout.name == padding)
    return !text.empty();
  switch (stored) {
  case Stored::Exactly:
    return true;
  case Stored::Nearly:
    ++inexact_[field];
    return !isCoordinate(cloud_, layout);
  case Stored::No:
    break;
  }
  return false;
}

void ValueStore::warn(const std::string& path)
{
  for (std::size_t i = 0; i < inexact_.size(); ++i)
    if (inexact_[i] > 0)
      cloud_.warnings.push_back(path + ": field " + cloud_.data.fields[i].name + ": its type does not hold " +
                                std::to_string(inexact_[i]) +
                                " of the values; of each the nearest that it holds is kept, or the same bits");
}

std::string whyNoNumber(std::string_view value, std::string_view rest_of_row, const std::string& path)
{
  if (value.empty())
    return "is missing";
  std::string why = "'" + std::string(value.substr(0, 40)) + "' is not such a number";
  const auto commas = std::count(value.begin(), value.end(), ',');
  if (commas == 0)
    return why;
  const bool decimal = commas == 1 && value.back() != ',' && (rest_of_row.find(',') != std::string_view::npos);
  return why + (decimal ? "; for decimal commas: " + filtered("tr , .", path)
                        : "; for commas between values: " + filtered("tr , ' '", path));
}

void widenCoordinates(Cloud& cloud, const std::string& path)
{
  const auto isWidened = [&cloud](const Field& field) {
    return isCoordinate(cloud, field) && !isReal(field) && field.count == 1;
  };
  const auto& old = cloud.data;
  if (std::none_of(old.fields.begin(), old.fields.end(), isWidened))
    return;
  Cloud wide;
  for (const Field& field : old.fields)
    addField(wide, path, field.name, isWidened(field) ? std::uint8_t(Field::FLOAT64) : field.datatype, field.count);
  wide.setSize(old.width, old.height, path);
  wide.data.data.resize(wide.size() * wide.data.point_step);
  for (std::size_t i = 0; i < old.fields.size(); ++i) {
    const Field& field = old.fields[i];
    const bool widened = isWidened(field);
    const std::uint8_t* from = old.data.data() + field.offset;
    std::uint8_t* to = wide.data.data.data() + wide.data.fields[i].offset;
    for (std::size_t row = 0; row < cloud.size(); ++row, from += old.point_step, to += wide.data.point_step) {
      const double value = widened ? loadNumber(from, field.datatype) : 0;
      if (widened)
        std::memcpy(to, &value, sizeof value);
      else
        std::memcpy(to, from, fieldSize(field.datatype) * field.count);
    }
  }
  cloud.data = std::move(wide.data);
  cloud.warnings.push_back(path + ": its coordinates are integers; they are read, and written, as double");
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
    value[axis] = loadNumber(from, fields_[axis].datatype);
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
    const float narrow = toFloat(value[axis]);
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
      throw inputFailure(path, std::string("field ") + name + " is not one number per point");
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
