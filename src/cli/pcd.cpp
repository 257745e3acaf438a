#include "cli/pcd.h"

#include "cli/input_file.h"
#include "cli/number.h"

#include <pcl/io/lzf.h>
#include <pcl/io/pcd_io.h>

#include <cstring>
#include <optional>
#include <sstream>

namespace pcl_gpu_icp::cli {
namespace {

std::vector<std::string_view> words(std::string_view line)
{
  std::vector<std::string_view> result;
  for (auto word = nextWord(line); !word.empty(); word = nextWord(line))
    result.push_back(word);
  return result;
}

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
    if (encoding_ == "ascii")
      readAscii();
    else if (encoding_ == "binary")
      readBinary();
    else if (encoding_ == "binary_compressed")
      readCompressed();
    else
      fail("DATA " + std::string(encoding_.substr(0, 40)) + " is not ascii, binary or binary_compressed");
    return std::move(cloud_);
  }

private:
  [[noreturn]] void fail(const std::string& why) const { throw inputFailure(path_, why); }

  std::size_t count(const std::vector<std::string_view>& line, std::size_t i) const
  {
    const auto value = i < line.size() ? parseNumber<std::uint32_t>(line[i]) : std::nullopt;
    if (!value)
      fail("the header's " + std::string(line[0]) + " is not a whole number");
    return *value;
  }

  void readHeader()
  {
    std::vector<std::string_view> names, sizes, types, counts;
    std::optional<std::size_t> width, height, points;
    while (encoding_.empty()) {
      if (rest_.empty())
        fail("is not a PCD or PLY file: no DATA line");
      const auto line = words(nextLine(rest_));
      if (line.empty() || line[0].front() == '#' || line[0] == "VERSION")
        continue;
      if (line[0] == "FIELDS" || line[0] == "COLUMNS")
        names.assign(line.begin() + 1, line.end());
      else if (line[0] == "SIZE")
        sizes = line;
      else if (line[0] == "TYPE")
        types = line;
      else if (line[0] == "COUNT")
        counts = line;
      else if (line[0] == "WIDTH")
        width = count(line, 1);
      else if (line[0] == "HEIGHT")
        height = count(line, 1);
      else if (line[0] == "POINTS")
        points = count(line, 1);
      else if (line[0] == "VIEWPOINT")
        readViewpoint(line);
      else if (line[0] == "DATA" && line.size() > 1)
        encoding_ = line[1];
      else
        fail("is not a PCD or PLY file: its header has a line that starts with neither's words");
    }
    readFields(names, sizes, types, counts);
    setSize(width, height, points);
  }

  void readViewpoint(const std::vector<std::string_view>& line)
  {
    std::array<float, 7> value{};
    for (std::size_t i = 0; i < value.size(); ++i) {
      const auto number = i + 1 < line.size() ? parseNumber<float>(line[i + 1]) : std::nullopt;
      if (!number)
        fail("the header's VIEWPOINT does not have 7 numbers");
      value[i] = *number;
    }
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
      const auto type = kind.size() == 1 ? fieldType(kind[0], size) : 0;
      if (type == 0)
        fail("field " + name + ": TYPE " + std::string(kind.substr(0, 40)) + " of SIZE " + std::to_string(size) +
             " is not supported");
      constexpr std::size_t most_values = 1 << 16;
      if (values < 1 || values > most_values)
        fail("field " + name + ": COUNT " + std::to_string(values) + " is not from 1 to 65536");
      addField(cloud_.data, name, type, static_cast<std::uint32_t>(values));
    }
  }

  void setSize(std::optional<std::size_t> width, std::optional<std::size_t> height, std::optional<std::size_t> points)
  {
    if (!points && !width)
      fail("the header has no POINTS");
    const std::size_t rows = height.value_or(1);
    const std::size_t columns = width.value_or(points.value_or(0));
    if (rows * columns != points.value_or(rows * columns))
      fail("the header's WIDTH " + std::to_string(columns) + " x HEIGHT " + std::to_string(rows) +
           " is not its POINTS " + std::to_string(*points));
    cloud_.setSize(columns, rows, path_);
  }

  void readBinary()
  {
    auto& data = cloud_.data.data;
    const std::size_t needed = cloud_.size() * cloud_.data.point_step;
    if (rest_.size() < needed)
      fail("the header promises " + std::to_string(cloud_.size()) + " points, the data end after " +
           std::to_string(rest_.size() / cloud_.data.point_step));
    data.assign(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(needed));
  }

  void readCompressed()
  {
    std::uint32_t sizes[2] = {0, 0}; // compressed, uncompressed
    if (rest_.size() >= sizeof sizes)
      std::memcpy(sizes, rest_.data(), sizeof sizes);
    rest_.remove_prefix(std::min(sizeof sizes, rest_.size()));
    const std::size_t needed = cloud_.size() * cloud_.data.point_step;
    if (sizes[1] != needed)
      fail("the header promises " + std::to_string(needed) + " bytes of points, the compressed data hold " +
           std::to_string(sizes[1]));
    if (sizes[0] > rest_.size())
      fail("ends after " + std::to_string(rest_.size()) + " of " + std::to_string(sizes[0]) +
           " bytes of compressed data");
    constexpr std::size_t best_lzf_ratio = 88; // 3 bytes make at most 264
    if (needed / best_lzf_ratio > sizes[0])
      fail("the compressed data are corrupt: too short for the points they promise");
    std::vector<std::uint8_t> columns(needed);
    if (pcl::lzfDecompress(rest_.data(), sizes[0], columns.data(), sizes[1]) != needed)
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
    auto& cloud = cloud_.data;
    std::size_t values = 0;
    for (const auto& field : cloud.fields)
      values += field.count;
    constexpr std::size_t least_bytes_per_value = 2;
    if ((rest_.size() + 1) / least_bytes_per_value / values < cloud_.size())
      fail("the header promises " + std::to_string(cloud_.size()) + " points, the data are too short for them");
    cloud.data.resize(cloud_.size() * cloud.point_step);
    std::size_t rows = 0;
    while (!rest_.empty()) {
      std::string_view row = nextLine(rest_);
      std::string_view value = nextWord(row);
      if (value.empty())
        continue;
      if (rows == cloud_.size())
        fail("has more points than the " + std::to_string(rows) + " that the header promises");
      std::uint8_t* point = cloud.data.data() + rows * cloud.point_step;
      ++rows;
      for (const auto& field : cloud.fields)
        for (std::uint32_t i = 0; i < field.count; ++i, value = nextWord(row))
          if (!storeNumber(value, field.datatype, point + field.offset + i * fieldSize(field.datatype)))
            fail("point " + std::to_string(rows) + ", field " + field.name + ": " +
                 (value.empty() ? "is missing" : "'" + std::string(value.substr(0, 40)) + "' is not such a number"));
      if (!value.empty())
        fail("point " + std::to_string(rows) + " has more values than there are fields");
    }
    if (rows < cloud_.size())
      fail("the header promises " + std::to_string(cloud_.size()) + " points, the data end after " +
           std::to_string(rows));
  }

  const std::string& path_;
  std::string_view rest_;
  std::string_view encoding_;
  Cloud cloud_;
};

} // namespace

Cloud readPcd(const std::string& path, std::string_view content) { return Reader(path, content).read(); }

std::string writePcd(const Cloud& cloud)
{
  std::ostringstream content;
  if (pcl::PCDWriter().writeBinaryCompressed(content, cloud.data, cloud.sensor_origin, cloud.sensor_orientation) != 0)
    throw std::runtime_error("PCL cannot write this cloud as PCD");
  return content.str();
}

} // namespace pcl_gpu_icp::cli
