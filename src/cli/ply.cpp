#include "cli/ply.h"

#include "cli/input_file.h"
#include "cli/number.h"

#include <algorithm>
#include <cstring>
#include <optional>

namespace pcl_gpu_icp::cli {
namespace {

using Field = pcl::PCLPointField;

struct Type {
  const char* name;
  const char* other_name;
  std::uint8_t field_type;
};

constexpr Type types[] = {{"char", "int8", Field::INT8},
                          {"uchar", "uint8", Field::UINT8},
                          {"short", "int16", Field::INT16},
                          {"ushort", "uint16", Field::UINT16},
                          {"int", "int32", Field::INT32},
                          {"uint", "uint32", Field::UINT32},
                          {"float", "float32", Field::FLOAT32},
                          {"double", "float64", Field::FLOAT64}};

/// Names that PCL and PLY spell differently.
constexpr const char* renamed_fields[][2] = {{"normal_x", "nx"}, {"normal_y", "ny"}, {"normal_z", "nz"}};

/// Bytes of PCL's packed colour, 0xAARRGGBB in a little-endian word.
constexpr const char* colours[] = {"blue", "green", "red", "alpha"};

struct Property {
  std::string name;
  std::uint8_t type = 0;
  std::uint8_t count_type = 0; ///< of a list; 0: not a list
  std::size_t offset = 0;      ///< in the point, for a vertex's property

  std::size_t size() const { return fieldSize(type); }
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;

  bool hasList() const
  {
    return std::any_of(
        properties.begin(), properties.end(), [](const Property& property) { return property.count_type != 0; });
  }
  std::size_t size() const
  {
    std::size_t bytes = 0;
    for (const Property& property : properties)
      bytes += property.size();
    return bytes;
  }
};

class Reader {
public:
  Reader(const std::string& path, std::string_view content)
  : path_(path)
  , rest_(content)
  {
  }

  Cloud read()
  {
    readHeader();
    const auto vertex = std::find_if(
        elements_.begin(), elements_.end(), [](const Element& element) { return element.name == "vertex"; });
    if (vertex == elements_.end())
      fail("has no element vertex");
    layOut(*vertex);
    for (auto before = elements_.begin(); before != vertex; ++before)
      skip(*before);
    if (vertex->size() * vertex->count > (ascii_ ? rest_.size() * sizeof(double) : rest_.size()))
      failTruncated(*vertex);
    cloud_.data.data.resize(cloud_.size() * cloud_.data.point_step);
    if (ascii_)
      readAscii(*vertex);
    else
      readBinary(*vertex);
    return std::move(cloud_);
  }

private:
  [[noreturn]] void fail(const std::string& why) const { throw inputFailure(path_, why); }

  [[noreturn]] void failTruncated(const Element& element) const
  {
    fail("ends before the " + std::to_string(element.count) + " of element " + element.name +
         " that its header promises");
  }

  void readHeader()
  {
    nextLine(rest_); // "ply"
    for (bool ended = false; !ended;) {
      if (rest_.empty())
        fail("its PLY header does not end");
      std::string_view line = nextLine(rest_);
      const std::string_view keyword = nextWord(line);
      if (keyword == "end_header")
        ended = true;
      else if (keyword == "format")
        readFormat(nextWord(line));
      else if (keyword == "element")
        readElement(line);
      else if (keyword == "property")
        readProperty(line);
      else if (keyword == "obj_info")
        readGridSize(line);
      else if (!keyword.empty() && keyword != "comment")
        fail("its PLY header has a line that starts with " + std::string(keyword.substr(0, 40)));
    }
    if (!format_known_)
      fail("its PLY header has no format");
  }

  void readFormat(std::string_view format)
  {
    ascii_ = format == "ascii";
    swap_bytes_ = format == "binary_big_endian";
    format_known_ = ascii_ || swap_bytes_ || format == "binary_little_endian";
    if (!format_known_)
      fail("PLY format " + std::string(format.substr(0, 40)) + " is not known");
  }

  void readElement(std::string_view line)
  {
    Element element;
    element.name = nextWord(line);
    const auto count = parseNumber<std::uint32_t>(nextWord(line));
    if (!count)
      fail("the count of element " + element.name + " is not a whole number");
    element.count = *count;
    elements_.push_back(element);
  }

  void readProperty(std::string_view line)
  {
    if (elements_.empty())
      fail("its PLY header has a property of no element");
    Property property;
    std::string_view type = nextWord(line);
    if (type == "list") {
      property.count_type = typeNamed(nextWord(line));
      type = nextWord(line);
    }
    property.type = typeNamed(type);
    property.name = nextWord(line);
    elements_.back().properties.push_back(property);
  }

  std::uint8_t typeNamed(std::string_view name) const
  {
    for (const Type& type : types)
      if (name == type.name || name == type.other_name)
        return type.field_type;
    fail("PLY type '" + std::string(name.substr(0, 40)) + "' is not known");
  }

  void readGridSize(std::string_view line)
  {
    const std::string_view what = nextWord(line);
    if (what == "num_cols")
      columns_ = parseNumber<std::uint32_t>(nextWord(line)).value_or(0);
    else if (what == "num_rows")
      rows_ = parseNumber<std::uint32_t>(nextWord(line)).value_or(0);
  }

  /// Gives every property of the vertices its place in the points.
  void layOut(Element& vertex)
  {
    auto& cloud = cloud_.data;
    std::array<Property*, 4> colour{};
    for (Property& property : vertex.properties) {
      if (property.count_type != 0)
        fail("vertex property " + property.name + " is a list, which a point cloud cannot hold");
      for (int i = 0; i < 4; ++i)
        if (property.name == colours[i] && property.type == Field::UINT8)
          colour[i] = &property;
    }
    const bool packed = colour[0] && colour[1] && colour[2];
    for (Property& property : vertex.properties) {
      const bool is_colour = packed && std::find(colour.begin(), colour.end(), &property) != colour.end();
      if (is_colour)
        continue;
      property.offset = cloud.point_step;
      std::string name = property.name;
      for (const auto& renamed : renamed_fields)
        if (name == renamed[1])
          name = renamed[0];
      addField(cloud, name, property.type);
    }
    if (packed) {
      for (std::size_t byte = 0; byte < colour.size(); ++byte)
        if (colour[byte])
          colour[byte]->offset = cloud.point_step + byte;
      if (colour[3])
        addField(cloud, "rgba", Field::UINT32);
      else
        addField(cloud, "rgb", Field::FLOAT32);
    }
    if (cloud.point_step == 0)
      fail("element vertex has no properties");
    const bool organised = rows_ > 1 && rows_ * columns_ == vertex.count;
    cloud_.setSize(organised ? columns_ : vertex.count, organised ? rows_ : 1, path_);
  }

  std::string_view take(std::size_t bytes, const Element& element)
  {
    if (bytes > rest_.size())
      failTruncated(element);
    const std::string_view taken = rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
    return taken;
  }

  std::size_t takeListLength(const Property& list, const Element& element)
  {
    const std::string_view bytes = take(fieldSize(list.count_type), element);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
      value |= std::uint64_t(std::uint8_t(bytes[swap_bytes_ ? bytes.size() - 1 - i : i])) << (8 * i);
    return value > rest_.size() ? rest_.size() + 1 : value;
  }

  std::string_view nextRow(const Element& element)
  {
    std::string_view row;
    while (row.find_first_not_of(" \t\r") == std::string_view::npos) {
      if (rest_.empty())
        failTruncated(element);
      row = nextLine(rest_);
    }
    return row;
  }

  void skip(const Element& element)
  {
    if (!element.hasList() && !ascii_) {
      take(element.size() * element.count, element);
      return;
    }
    for (std::size_t i = 0; i < element.count; ++i) {
      if (ascii_) {
        nextRow(element);
        continue;
      }
      for (const Property& property : element.properties)
        take(property.size() * (property.count_type ? takeListLength(property, element) : 1), element);
    }
  }

  void readAscii(const Element& vertex)
  {
    std::uint8_t* point = cloud_.data.data.data();
    for (std::size_t row = 1; row <= vertex.count; ++row, point += cloud_.data.point_step) {
      std::string_view line = nextRow(vertex);
      for (const Property& property : vertex.properties) {
        const std::string_view value = nextWord(line);
        if (!storeNumber(value, property.type, point + property.offset))
          fail("vertex " + std::to_string(row) + ", property " + property.name + ": " +
               (value.empty() ? "is missing" : "'" + std::string(value.substr(0, 40)) + "' is not such a number"));
      }
      if (!nextWord(line).empty())
        fail("vertex " + std::to_string(row) + " has more values than there are properties");
    }
  }

  void readBinary(const Element& vertex)
  {
    const char* from = rest_.data();
    std::uint8_t* point = cloud_.data.data.data();
    for (std::size_t row = 0; row < vertex.count; ++row, point += cloud_.data.point_step)
      for (const Property& property : vertex.properties) {
        const std::size_t size = property.size();
        std::uint8_t* to = point + property.offset;
        if (swap_bytes_)
          std::reverse_copy(from, from + size, to);
        else
          std::copy(from, from + size, to);
        from += size;
      }
  }

  const std::string& path_;
  std::string_view rest_;
  std::vector<Element> elements_;
  bool format_known_ = false;
  bool ascii_ = false;
  bool swap_bytes_ = false;
  std::size_t columns_ = 0; ///< from obj_info; 0: not given
  std::size_t rows_ = 0;
  Cloud cloud_;
};

bool isPackedColour(const Field& field)
{
  return (field.name == "rgb" || field.name == "rgba") && fieldSize(field.datatype) == 4 && field.count == 1;
}

std::string propertyLine(const std::string& type, const std::string& name)
{
  return "property " + type + " " + name + "\n";
}

std::string propertyLines(const Field& field)
{
  const auto type = std::find_if(std::begin(types), std::end(types), [&field](const Type& candidate) {
    return candidate.field_type == field.datatype;
  });
  if (type == std::end(types))
    throw Failure(ExitCode::Output,
                  "field " + field.name + " has 8-byte integers, which PLY does not have; write .pcd");
  std::string name = field.name;
  for (const auto& renamed : renamed_fields)
    if (name == renamed[0])
      name = renamed[1];
  if (field.count == 1)
    return propertyLine(type->name, name);
  std::string lines;
  for (std::uint32_t i = 0; i < field.count; ++i)
    lines += propertyLine(type->name, name + "_" + std::to_string(i));
  return lines;
}

} // namespace

Cloud readPly(const std::string& path, std::string_view content) { return Reader(path, content).read(); }

std::string plyHeader(const Cloud& cloud)
{
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  if (cloud.data.height > 1)
    header += "obj_info num_cols " + std::to_string(cloud.data.width) + "\nobj_info num_rows " +
              std::to_string(cloud.data.height) + "\n";
  header += "element vertex " + std::to_string(cloud.size()) + "\n";
  for (const Field& field : cloud.data.fields) {
    if (!isPackedColour(field)) {
      header += propertyLines(field);
      continue;
    }
    for (const char* colour : {"red", "green", "blue"})
      header += propertyLine("uchar", colour);
    if (field.name == "rgba")
      header += propertyLine("uchar", "alpha");
  }
  return header + "end_header\n";
}

std::string writePly(const Cloud& cloud)
{
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the bytes of the points are written as they are");
  std::string content = plyHeader(cloud);
  content.reserve(content.size() + cloud.data.data.size());
  const auto* point = reinterpret_cast<const char*>(cloud.data.data.data());
  for (std::size_t i = 0; i < cloud.size(); ++i, point += cloud.data.point_step)
    for (const Field& field : cloud.data.fields) {
      const char* value = point + field.offset;
      if (isPackedColour(field)) {
        const char rgba[] = {value[2], value[1], value[0], value[3]};
        content.append(rgba, field.name.size());
      }
      else {
        content.append(value, fieldSize(field.datatype) * field.count);
      }
    }
  return content;
}

} // namespace pcl_gpu_icp::cli
