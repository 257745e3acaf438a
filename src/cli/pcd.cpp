#include "cli/pcd.h"

#include "cli/input_file.h"
#include "cli/line_reader.h"
#include "cli/lower_case.h"
#include "cli/number.h"

#include "report/format.h"

#include <lzf.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

namespace pcl_gpu_icp::cli {
namespace {

constexpr const char* correct_sizes = "; correct WIDTH, HEIGHT and POINTS, or delete these lines";
constexpr std::array<float, 7> default_viewpoint{0, 0, 0, 1, 0, 0, 0};

std::vector<std::string_view> words(std::string_view line, std::string_view separators = " \t\r")
{
  std::vector<std::string_view> result;
  for (auto word = nextWord(line, separators); !word.empty(); word = nextWord(line, separators))
    result.push_back(word);
  return result;
}

class Reader : LineReader {
public:
  using LineReader::LineReader;

  Cloud read()
  {
    readHeader();
    if (encoding_ == "ascii")
      readAscii();
    else if (encoding_ == "binary")
      readBinary();
    else if (encoding_ == "binary_compressed")
      readCompressed();
    else
      fail("DATA " + encoding_.substr(0, 40) + " is not ascii, binary or binary_compressed");
    widenCoordinates(cloud_, path_);
    return std::move(cloud_);
  }

private:
  [[noreturn]] void fail(const std::string& why) const { throw inputFailure(path_, why); }

  std::size_t count(const std::vector<std::string_view>& line, std::size_t i) const
  {
    const auto value = i < line.size() ? parseNumber<std::uint64_t>(line[i]) : std::nullopt;
    if (!value)
      fail("the header's " + std::string(line[0]) + " is not a whole number");
    return *value;
  }

  void readHeader()
  {
    std::vector<std::string_view> names, sizes, types, counts;
    std::optional<std::size_t> width, height, points;
    std::string_view unknown;
    while (encoding_.empty()) {
      if (rest_.empty())
        fail("is not a PCD or PLY file: no DATA line");
      const std::string_view whole = nextLine(rest_, line_end_);
      const auto line = words(whole);
      if (line.empty())
        continue;
      const std::string keyword = lowerCase(line[0]);
      if (keyword[0] == '#')
        readComment(whole);
      else if (keyword == "fields" || keyword == "columns")
        names.assign(line.begin() + 1, line.end());
      else if (keyword == "size")
        sizes = line;
      else if (keyword == "type")
        types = line;
      else if (keyword == "count")
        counts = line;
      else if (keyword == "width")
        width = count(line, 1);
      else if (keyword == "height")
        height = count(line, 1);
      else if (keyword == "points")
        points = count(line, 1);
      else if (keyword == "viewpoint")
        readViewpoint(words(whole, " \t\r,"));
      else if (keyword == "data" && line.size() > 1)
        encoding_ = lowerCase(line[1]);
      else if (keyword != "version" && unknown.empty())
        unknown = line[0].substr(0, 40);
    }
    if (!unknown.empty())
      cloud_.warnings.push_back(path_ +
                                ": its header has lines that PCD does not know, which are skipped; one starts with " +
                                std::string(unknown));
    readFields(names, sizes, types, counts);
    if (!points && !width)
      points = pointsThereAre();
    setSize(width, height, points);
  }

  /// Keeps its text as a PLY file has it. The first line only names the format.
  void readComment(std::string_view line)
  {
    line.remove_prefix(line.find('#') + 1);
    while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back())))
      line.remove_suffix(1);
    if (line.find(".PCD v") == std::string_view::npos)
      cloud_.comments.push_back((line.substr(0, 1) == " " ? "comment" : "comment ") + std::string(line));
  }

  /// Seven numbers, or only the three of the place.
  void readViewpoint(const std::vector<std::string_view>& line)
  {
    std::array<float, 7> value = default_viewpoint;
    const std::size_t numbers = std::min(line.size() - 1, value.size());
    if (numbers != 3 && numbers < value.size())
      fail("the header's VIEWPOINT does not have 7 numbers, of the place x y z and the orientation qw qx qy qz");
    for (std::size_t i = 0; i < numbers; ++i) {
      const auto number = parseReal(line[i + 1]);
      if (!number)
        fail("the header's VIEWPOINT does not have 7 numbers: '" + std::string(line[i + 1].substr(0, 40)) + "'");
      value[i] = std::abs(*number) <= std::numeric_limits<float>::max() ? static_cast<float>(*number) : NAN;
      if (std::isnan(value[i])) {
        cloud_.warnings.push_back(path_ + ": its VIEWPOINT is not finite; it is taken as 0 0 0 1 0 0 0");
        return;
      }
    }
    cloud_.has_pose = value != default_viewpoint;
    cloud_.sensor_origin = {value[0], value[1], value[2], 0};
    cloud_.sensor_orientation = {value[3], value[4], value[5], value[6]};
  }

  void readFields(const std::vector<std::string_view>& names,
                  const std::vector<std::string_view>& sizes,
                  const std::vector<std::string_view>& types,
                  const std::vector<std::string_view>& counts)
  {
    if (names.empty())
      fail("the header has no FIELDS");
    for (const auto* line : {&sizes, &types, &counts})
      if (!line->empty() && line->size() != names.size() + 1)
        fail("the header's " + std::string(line->front()) + " has " + std::to_string(line->size() - 1) +
             " entries for " + std::to_string(names.size()) + " FIELDS");
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string name(names[i]);
      const std::size_t size = sizes.empty() ? 4 : count(sizes, i + 1);
      const std::string_view kind = types.empty() ? "F" : types[i + 1];
      const std::size_t values = counts.empty() ? 1 : count(counts, i + 1);
      if (values == 0) // padding of no bytes
        continue;
      const auto upper = static_cast<char>(std::toupper(static_cast<unsigned char>(kind[0])));
      const auto type = kind.size() == 1 ? fieldType(upper, size) : 0;
      if (type == 0)
        fail("field " + name + ": TYPE " + std::string(kind.substr(0, 40)) + " of SIZE " + std::to_string(size) +
             " is not supported");
      addField(cloud_, path_, name, type, values);
    }
  }

  /// Of a header that does not say how many.
  std::size_t pointsThereAre() const
  {
    const std::size_t step = std::max<std::size_t>(cloud_.data.point_step, 1);
    if (encoding_ == "binary")
      return rest_.size() / step;
    if (encoding_ == "binary_compressed")
      return compressedSizes()[1] / step;
    std::size_t rows = 0;
    for (std::string_view rest = rest_; !rest.empty();) {
      std::string_view row = nextLine(rest, line_end_);
      if (!nextWord(row).empty())
        ++rows;
    }
    return rows;
  }

  void setSize(std::optional<std::size_t> width, std::optional<std::size_t> height, std::optional<std::size_t> points)
  {
    const std::size_t rows = height.value_or(1);
    const std::size_t columns = width ? *width : rows == 0 ? 0 : *points / rows;
    std::size_t product = 0;
    if (__builtin_mul_overflow(rows, columns, &product))
      fail("the header's WIDTH x HEIGHT is beyond 64 bits");
    if (points && product != *points)
      fail("the header's WIDTH " + std::to_string(columns) + " x HEIGHT " + std::to_string(rows) +
           " is not its POINTS " + std::to_string(*points) + correct_sizes);
    cloud_.setSize(columns, rows, path_);
  }

  [[noreturn]] void failPromise(const std::string& what_there_is) const
  {
    fail("the header promises " + std::to_string(cloud_.size()) + " points, the data " + what_there_is + correct_sizes);
  }

  void readBinary()
  {
    const std::size_t needed = cloud_.size() * cloud_.data.point_step;
    if (rest_.size() < needed)
      failPromise("end after " + std::to_string(rest_.size() / cloud_.data.point_step));
    cloud_.data.data.assign(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(needed));
  }

  /// Bytes of the data, compressed and not.
  std::array<std::uint32_t, 2> compressedSizes() const
  {
    std::array<std::uint32_t, 2> sizes{};
    if (rest_.size() >= sizeof sizes)
      std::memcpy(sizes.data(), rest_.data(), sizeof sizes);
    return sizes;
  }

  void readCompressed()
  {
    const auto sizes = compressedSizes();
    rest_.remove_prefix(std::min(sizeof sizes, rest_.size()));
    const std::size_t needed = cloud_.size() * cloud_.data.point_step;
    if (sizes[1] != needed)
      fail("the header promises " + std::to_string(needed) + " bytes of points, the compressed data hold " +
           std::to_string(sizes[1]) + correct_sizes);
    if (sizes[0] > rest_.size())
      fail("ends after " + std::to_string(rest_.size()) + " of " + std::to_string(sizes[0]) +
           " bytes of compressed data");
    constexpr std::size_t best_lzf_ratio = 88; // 3 bytes make at most 264
    if (needed / best_lzf_ratio > sizes[0])
      fail("the compressed data are corrupt: too short for the points they promise");
    std::vector<std::uint8_t> columns(needed);
    if (lzf_decompress(rest_.data(), sizes[0], columns.data(), sizes[1]) != needed)
      fail("the compressed data are corrupt");
    interleave(columns);
  }

  /// Compressed files keep all values of a field together.
  void interleave(const std::vector<std::uint8_t>& columns)
  {
    auto& cloud = cloud_.data;
    cloud.data.resize(columns.size());
    const std::uint8_t* from = columns.data();
    for (const auto& field : cloud.fields) {
      const std::size_t size = fieldSize(field.datatype) * field.count;
      std::uint8_t* to = cloud.data.data() + field.offset;
      for (std::size_t i = 0; i < cloud_.size(); ++i, from += size, to += cloud.point_step)
        std::memcpy(to, from, size);
    }
  }

  void readAscii()
  {
    rest_ = withoutByteOrderMark(rest_);
    auto& cloud = cloud_.data;
    std::size_t values = 0;
    for (const auto& field : cloud.fields)
      values += field.count;
    constexpr std::size_t least_bytes_per_value = 2;
    if ((rest_.size() + 1) / least_bytes_per_value / values < cloud_.size())
      failPromise("are too short for them");
    cloud.data.resize(cloud_.size() * cloud.point_step);
    ValueStore store(cloud_);
    std::size_t rows = 0;
    while (!rest_.empty()) {
      std::string_view row = nextLine(rest_, line_end_);
      std::string_view value = nextWord(row);
      if (value.empty())
        continue;
      if (rows == cloud_.size())
        failPromise("have more points than that");
      std::uint8_t* point = cloud.data.data() + rows * cloud.point_step;
      ++rows;
      for (std::size_t place = 0; place < cloud.fields.size(); ++place) {
        const auto& field = cloud.fields[place];
        for (std::uint32_t i = 0; i < field.count; ++i, value = nextWord(row))
          if (!store.store(value, place, field.datatype, point + field.offset + i * fieldSize(field.datatype)))
            fail("point " + std::to_string(rows) + ", field " + field.name + ": " + whyNoNumber(value, row, path_));
      }
      if (!value.empty())
        fail("point " + std::to_string(rows) + " has more values than there are fields");
    }
    if (rows < cloud_.size())
      failPromise("end after " + std::to_string(rows));
    store.warn(path_);
  }

  std::string encoding_;
  Cloud cloud_;
};

/// All values of a field together, as compressed files keep them.
std::vector<std::uint8_t> separate(const Cloud& cloud)
{
  const auto& data = cloud.data;
  std::vector<std::uint8_t> columns(cloud.size() * data.point_step);
  std::uint8_t* to = columns.data();
  for (const auto& field : data.fields) {
    const std::size_t size = fieldSize(field.datatype) * field.count;
    const std::uint8_t* from = data.data.data() + field.offset;
    for (std::size_t i = 0; i < cloud.size(); ++i, to += size, from += data.point_step)
      std::memcpy(to, from, size);
  }
  return columns;
}

std::string header(const Cloud& cloud, const char* encoding)
{
  std::string names, sizes, types, counts;
  for (const auto& field : cloud.data.fields) {
    names += " " + field.name;
    sizes += " " + std::to_string(fieldSize(field.datatype));
    types += std::string(" ") + fieldKind(field.datatype);
    counts += " " + std::to_string(field.count);
  }
  std::string lines = "# .PCD v0.7 - Point Cloud Data file format\n";
  const std::string word = "comment ";
  for (const std::string& comment : cloud.comments)
    lines += "# " + comment.substr(comment.compare(0, word.size(), word) == 0 ? word.size() : 0) + "\n";
  lines += "VERSION 0.7\nFIELDS" + names + "\nSIZE" + sizes + "\nTYPE" + types + "\nCOUNT" + counts;
  lines += "\nWIDTH " + std::to_string(cloud.data.width) + "\nHEIGHT " + std::to_string(cloud.data.height);
  const Eigen::Vector4f& place = cloud.sensor_origin;
  const Eigen::Quaternionf& turn = cloud.sensor_orientation;
  lines += "\nVIEWPOINT";
  for (const float number : {place.x(), place.y(), place.z(), turn.w(), turn.x(), turn.y(), turn.z()})
    lines += report::format(" %.9g", static_cast<double>(number));
  return lines + "\nPOINTS " + std::to_string(cloud.size()) + "\nDATA " + encoding + "\n";
}

} // namespace

Cloud readPcd(const std::string& path, std::string_view content) { return Reader(path, content).read(); }

std::string writePcd(const Cloud& cloud)
{
  const auto& fields = cloud.data.fields;
  if (std::any_of(fields.begin(), fields.end(), [](const auto& field) { return field.name == padding; })) {
    // Of compressed ones with padding PCL reads other points than were written.
    std::string content = header(cloud, "binary");
    return content.append(cloud.data.data.begin(), cloud.data.data.end());
  }
  const std::vector<std::uint8_t> columns = separate(cloud);
  constexpr std::size_t most = std::numeric_limits<std::uint32_t>::max();
  // Of 32 bytes that it cannot compress LZF makes 33.
  std::vector<char> packed(std::min(columns.size() + columns.size() / 16 + 64, most));
  const auto size = static_cast<std::uint32_t>(columns.size()); // as Cloud::setSize() bounds it
  const std::uint32_t packed_size =
      lzf_compress(columns.data(), size, packed.data(), static_cast<std::uint32_t>(packed.size()));
  if (packed_size == 0)
    throw std::runtime_error("LZF cannot compress this cloud");
  std::string content = header(cloud, "binary_compressed");
  content.append(reinterpret_cast<const char*>(&packed_size), sizeof packed_size);
  content.append(reinterpret_cast<const char*>(&size), sizeof size);
  return content.append(packed.data(), packed_size);
}

} // namespace pcl_gpu_icp::cli
