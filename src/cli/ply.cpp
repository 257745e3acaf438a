#include "cli/ply.h"

#include "cli/input_file.h"
#include "cli/line_reader.h"
#include "cli/lower_case.h"
#include "cli/number.h"
#include "cli/ply_format.h"

#include <algorithm>
#include <cstring>
#include <optional>

namespace pcl_gpu_icp::cli {
namespace {

using namespace ply;

struct Property {
  std::string name;
  std::uint8_t type = 0;
  std::uint8_t count_type = 0;       ///< of a list; 0: not a list
  std::optional<std::size_t> offset; ///< in the point, for a vertex's property that the cloud has
  std::size_t field = 0;             ///< which of the cloud's it is, or is a byte of

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

/// Where in an element's row the pose is, if it is one camera and has one.
std::optional<std::size_t> posePlace(const Element& element)
{
  if (element.name != "camera" || element.count != 1 || element.hasList())
    return std::nullopt;
  std::size_t offset = 0;
  std::size_t found = 0;
  for (const Property& property : element.properties) {
    if (found == std::size(pose_properties))
      break;
    if (property.name == pose_properties[found] && property.type == Field::FLOAT32)
      ++found;
    else if (found > 0)
      return std::nullopt;
    else
      offset += property.size();
  }
  return found == std::size(pose_properties) ? std::optional(offset) : std::nullopt;
}

class Reader : LineReader {
public:
  using LineReader::LineReader;

  Cloud read()
  {
    readHeader();
    const auto vertex = std::find_if(
        elements_.begin(), elements_.end(), [](const Element& element) { return element.name == "vertex"; });
    if (vertex == elements_.end())
      fail("has no element vertex");
    layOut(*vertex);
    if (ascii_)
      rest_ = withoutByteOrderMark(rest_);
    for (auto before = elements_.begin(); before != vertex; ++before)
      keep(*before, true);
    readVertices(*vertex);
    keepAfter(vertex + 1);
    takePose();
    widenCoordinates(cloud_, path_);
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
    std::string_view first;
    while (first.empty()) { // "ply", behind blank lines
      if (rest_.empty())
        fail("it is empty");
      std::string_view line = nextLine(rest_, line_end_);
      first = nextWord(line);
    }
    for (bool ended = false; !ended;) {
      if (rest_.empty())
        fail("its PLY header does not end");
      const std::string_view whole = nextLine(rest_, line_end_);
      std::string_view line = whole;
      const std::string keyword = lowerCase(nextWord(line));
      if (keyword == "end_header")
        ended = true;
      else if (keyword == "format")
        readFormat(lowerCase(nextWord(line)));
      else if (keyword == "element")
        readElement(line);
      else if (keyword == "property")
        readProperty(line);
      else if (keyword == "comment" || keyword == "obj_info")
        readComment(whole, line);
      else if (!keyword.empty())
        readComment("comment " + std::string(whole), line);
    }
    if (!format_known_)
      fail("its PLY header has no format");
  }

  void readFormat(const std::string& format)
  {
    ascii_ = format == "ascii";
    swap_bytes_ = format == "binary_big_endian";
    format_known_ = ascii_ || swap_bytes_ || format == "binary_little_endian";
    if (!format_known_)
      fail("PLY format " + format.substr(0, 40) + " is not known");
  }

  void readElement(std::string_view line)
  {
    Element element;
    element.name = nextWord(line);
    if (lowerCase(element.name) == "vertex")
      element.name = "vertex";
    const auto count = parseNumber<std::uint64_t>(nextWord(line));
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
    if (lowerCase(type) == "list") {
      property.count_type = typeNamed(nextWord(line));
      if (property.count_type == Field::FLOAT32 || property.count_type == Field::FLOAT64)
        fail("its PLY header has a list whose length is no integer");
      type = nextWord(line);
    }
    property.type = typeNamed(type);
    property.name = nextWord(line);
    if (property.name.empty())
      fail("element " + elements_.back().name + " has a property without a name");
    elements_.back().properties.push_back(property);
  }

  std::uint8_t typeNamed(std::string_view spelled) const
  {
    const std::string name = lowerCase(spelled);
    for (const Type& type : types)
      if (name == type.name || name == type.other_name)
        return type.field_type;
    std::uint8_t other = 0; // not of PLY, but seen
    if (name == "bool")
      other = Field::UINT8;
    else if (name == "int64" || name == "uint64")
      other = fieldType(name[0] == 'i' ? 'I' : 'U', 8);
    if (other == 0)
      fail("PLY type '" + name.substr(0, 40) + "' is not known");
    return other;
  }

  /// Takes the size of an organised cloud out of it, as plyHeader() writes that anew.
  void readComment(std::string_view whole, std::string_view words)
  {
    const std::string_view what = nextWord(words);
    std::size_t* size = what == "num_cols" ? &columns_ : what == "num_rows" ? &rows_ : nullptr;
    if (size && lowerCase(whole.substr(0, 8)) == "obj_info") {
      *size = parseNumber<std::uint32_t>(nextWord(words)).value_or(0);
      return;
    }
    if (!whole.empty() && whole.back() == '\r')
      whole.remove_suffix(1);
    cloud_.comments.emplace_back(whole);
  }

  /// Gives every property of the vertices its place in the points; a list has none.
  void layOut(Element& vertex)
  {
    std::array<Property*, 4> colour{};
    for (Property& property : vertex.properties)
      for (int i = 0; i < 4; ++i)
        if (property.name == colours[i] && property.type == Field::UINT8 && property.count_type == 0)
          colour[i] = &property;
    std::size_t lists = 0;
    std::string list;
    const bool packed = colour[0] && colour[1] && colour[2];
    for (Property& property : vertex.properties) {
      if (property.count_type != 0) {
        if (lists++ == 0)
          list = property.name;
        continue;
      }
      if (packed && std::find(colour.begin(), colour.end(), &property) != colour.end())
        continue;
      property.offset = cloud_.data.point_step;
      property.field = cloud_.data.fields.size();
      std::string name = property.name;
      for (const auto& renamed : renamed_fields)
        if (name == renamed[1])
          name = renamed[0];
      addField(cloud_, path_, name, property.type);
    }
    if (packed) {
      for (std::size_t byte = 0; byte < colour.size(); ++byte)
        if (colour[byte]) {
          colour[byte]->offset = cloud_.data.point_step + byte;
          colour[byte]->field = cloud_.data.fields.size();
        }
      if (colour[3])
        addField(cloud_, path_, "rgba", Field::UINT32);
      else
        addField(cloud_, path_, "rgb", Field::FLOAT32);
    }
    if (lists > 0)
      cloud_.warnings.push_back(path_ + ": property " + list +
                                " of its vertices is a list, which a point cloud cannot hold; " +
                                (lists == 1 ? "it is" : "all " + std::to_string(lists) + " lists are") + " skipped");
    const bool organised = rows_ > 1 && rows_ * columns_ == vertex.count;
    cloud_.setSize(organised ? columns_ : vertex.count, organised ? rows_ : 1, path_);
  }

  // ---------------------------------------------------------------------------------------------------------- the data

  /// A promise that the file is too short to keep is found out before any memory is asked for.
  void checkLength(const Element& element) const
  {
    std::size_t least = 0; // bytes of a row
    for (const Property& property : element.properties)
      least += ascii_ ? 2 : property.count_type ? fieldSize(property.count_type) : property.size();
    if (least > 0 && element.count > (rest_.size() + 1) / least)
      failTruncated(element);
  }

  std::string_view take(std::size_t bytes, const Element& element)
  {
    if (bytes > rest_.size())
      failTruncated(element);
    const std::string_view taken = rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
    return taken;
  }

  /// The next bytes of a binary value, little-endian.
  void takeValue(const Property& property, const Element& element, std::uint8_t* to)
  {
    const std::string_view bytes = take(property.size(), element);
    if (swap_bytes_)
      std::reverse_copy(bytes.begin(), bytes.end(), to);
    else
      std::copy(bytes.begin(), bytes.end(), to);
  }

  /// Begins a row of an ASCII element: all of its values are on a line, or, where the first row is not, anywhere.
  void startRow(const Element& element, std::size_t row)
  {
    if (row == 0)
      wrapped_ = false;
    in_first_row_ = row == 0;
    row_ = nextRow(element);
  }

  std::string_view nextRow(const Element& element)
  {
    if (wrapped_ && row_.find_first_not_of(" \t\r") != std::string_view::npos)
      return row_;
    std::string_view row;
    while (row.find_first_not_of(" \t\r") == std::string_view::npos) {
      if (rest_.empty())
        failTruncated(element);
      row = nextLine(rest_, line_end_);
    }
    return row;
  }

  /// Empty where a row ends too early.
  std::string_view nextValue(const Element& element)
  {
    const std::string_view value = nextWord(row_);
    wrapped_ = wrapped_ || (value.empty() && in_first_row_);
    if (!value.empty() || !wrapped_)
      return value;
    row_ = nextRow(element);
    return nextWord(row_);
  }

  [[noreturn]] void failValue(const Element& element, std::size_t row, const Property& property, std::string_view value)
  {
    fail(element.name + " " + std::to_string(row + 1) + ", property " + property.name + ": " +
         whyNoNumber(value, row_, path_));
  }

  void endRow(const Element& element, std::size_t row)
  {
    if ((!wrapped_ || row + 1 == element.count) && !nextWord(row_).empty())
      fail(element.name + " " + std::to_string(row + 1) + " has more values than there are properties");
  }

  /// The length of a list, which is appended to `body`, too.
  std::size_t readLength(const Property& list, const Element& element, std::size_t row, std::string* body)
  {
    std::array<std::uint8_t, sizeof(std::uint64_t)> bytes{};
    Property length;
    length.type = list.count_type;
    if (ascii_) {
      const std::string_view value = nextValue(element);
      if (storeNumber(value, list.count_type, bytes.data()) != Stored::Exactly)
        failValue(element, row, list, value);
    }
    else {
      takeValue(length, element, bytes.data());
    }
    if (body)
      body->append(reinterpret_cast<const char*>(bytes.data()), length.size());
    std::uint64_t value;
    std::memcpy(&value, bytes.data(), sizeof value);
    if (value > rest_.size() + row_.size())
      failTruncated(element);
    return value;
  }

  /// \param store of the vertices; null for another element, whose values are only converted
  void readValue(const Property& property, const Element& element, std::size_t row, std::uint8_t* to, ValueStore* store)
  {
    if (!ascii_) {
      takeValue(property, element, to);
      return;
    }
    const std::string_view value = nextValue(element);
    const bool is_number = store && property.offset ? store->store(value, property.field, property.type, to)
                                                    : storeNumber(value, property.type, to) != Stored::No;
    if (!is_number)
      failValue(element, row, property, value);
  }

  void readVertices(const Element& vertex)
  {
    checkLength(vertex);
    cloud_.data.data.resize(cloud_.size() * cloud_.data.point_step);
    ValueStore store(cloud_);
    std::uint8_t* point = cloud_.data.data.data();
    std::array<std::uint8_t, sizeof(double)> skipped{};
    for (std::size_t row = 0; row < vertex.count; ++row, point += cloud_.data.point_step) {
      if (ascii_)
        startRow(vertex, row);
      for (const Property& property : vertex.properties) {
        const std::size_t values = property.count_type ? readLength(property, vertex, row, nullptr) : 1;
        for (std::size_t i = 0; i < values; ++i)
          readValue(property, vertex, row, property.offset ? point + *property.offset : skipped.data(), &store);
      }
      if (ascii_)
        endRow(vertex, row);
    }
    store.warn(path_);
  }

  /// Keeps an element as it will be written.
  void keep(const Element& element, bool before_vertices)
  {
    checkLength(element);
    OtherElement kept;
    kept.name = element.name;
    kept.count = element.count;
    kept.before_vertices = before_vertices;
    kept.pose_at = posePlace(element);
    kept.header = "element " + element.name + " " + std::to_string(element.count) + "\n";
    for (const Property& property : element.properties)
      kept.header += propertyLine((property.count_type ? "list " + typeName(property.count_type) + " " : "") +
                                      typeName(property.type),
                                  property.name);
    std::array<std::uint8_t, sizeof(double)> value{};
    for (std::size_t row = 0; row < element.count && !element.properties.empty(); ++row) {
      if (ascii_)
        startRow(element, row);
      for (const Property& property : element.properties) {
        const std::size_t values = property.count_type ? readLength(property, element, row, &kept.body) : 1;
        for (std::size_t i = 0; i < values; ++i) {
          readValue(property, element, row, value.data(), nullptr);
          kept.body.append(reinterpret_cast<const char*>(value.data()), property.size());
        }
      }
      if (ascii_)
        endRow(element, row);
    }
    cloud_.elements.push_back(std::move(kept));
  }

  /// The points have been read: what is wrong behind them is no reason to refuse them.
  void keepAfter(std::vector<Element>::const_iterator element)
  {
    try {
      for (; element != elements_.end(); ++element)
        keep(*element, false);
    } catch (const Failure& failure) {
      cloud_.warnings.push_back(std::string(failure.what()) + "; element " + element->name +
                                " and what follows are left out");
    }
  }

  void takePose()
  {
    for (const OtherElement& element : cloud_.elements) {
      if (!element.pose_at)
        continue;
      std::array<float, std::size(pose_properties)> pose;
      std::memcpy(pose.data(), element.body.data() + *element.pose_at, sizeof pose);
      const Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> rows(pose.data() + 3);
      if (!rows.isUnitary(1e-3F) || !(rows.determinant() > 0)) // false for NaN, too
        continue;
      cloud_.has_pose = true;
      cloud_.sensor_origin = {pose[0], pose[1], pose[2], 0};
      cloud_.sensor_orientation = Eigen::Quaternionf(Eigen::Matrix3f(rows));
    }
  }

  std::vector<Element> elements_;
  bool format_known_ = false;
  bool ascii_ = false;
  bool swap_bytes_ = false;
  bool wrapped_ = false; ///< rows of this element may go on in the next line
  bool in_first_row_ = false;
  std::string_view row_;    ///< what is left of it
  std::size_t columns_ = 0; ///< from obj_info; 0: not given
  std::size_t rows_ = 0;
  Cloud cloud_;
};

} // namespace

Cloud readPly(const std::string& path, std::string_view content) { return Reader(path, content).read(); }

} // namespace pcl_gpu_icp::cli
