#include "cli/text_cloud.h"

#include "cli/cloud_scale.h"
#include "cli/input_file.h"
#include "cli/line_reader.h"
#include "cli/lower_case.h"
#include "cli/number.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace pcl_gpu_icp::cli {
namespace {

constexpr std::string_view blanks = " \t\r";

std::string_view trimmed(std::string_view text)
{
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  return text.substr(0, text.find_last_not_of(blanks) + 1);
}

/// What stands between the columns of a line: a semicolon, a comma, or blanks.
char separatorOf(std::string_view line)
{
  for (const char separator : {';', ','})
    if (line.find(separator) != std::string_view::npos)
      return separator;
  return ' ';
}

/// The columns of a line, one after another. Between two commas or semicolons there is one, if only an empty one.
class Columns {
public:
  Columns(std::string_view line, char separator)
  : rest_(trimmed(line))
  , separator_(separator)
  , ended_(rest_.empty())
  {
  }

  std::optional<std::string_view> next()
  {
    if (ended_)
      return std::nullopt;
    std::size_t end = 0;
    while (end < rest_.size() && !endsAt(rest_[end]))
      ++end;
    const std::string_view column = rest_.substr(0, end);
    ended_ = end == rest_.size();
    rest_.remove_prefix(ended_ ? end : end + 1);
    if (separator_ != ' ')
      return trimmed(column);
    while (!rest_.empty() && endsAt(rest_.front()))
      rest_.remove_prefix(1);
    return column;
  }

private:
  bool endsAt(char c) const { return separator_ == ' ' ? blanks.find(c) != std::string_view::npos : c == separator_; }

  std::string_view rest_;
  char separator_;
  bool ended_;
};

std::vector<std::string_view> columnsOf(std::string_view line)
{
  std::vector<std::string_view> result;
  Columns columns(line, separatorOf(line));
  while (const auto column = columns.next())
    result.push_back(*column);
  return result;
}

std::optional<double> parseCoordinate(std::string_view text)
{
  const auto plain = parseNumber<double>(text);
  return plain ? plain : parseReal(text);
}

bool startsWithPoint(const std::vector<std::string_view>& columns)
{
  return columns.size() >= 3 && std::all_of(columns.begin(), columns.begin() + 3, [](std::string_view column) {
           return parseCoordinate(column).has_value();
         });
}

/// The rest of a line that is one.
std::optional<std::string_view> commentIn(std::string_view line)
{
  line = trimmed(line);
  for (const std::string_view mark : {"#", "//"})
    if (line.substr(0, mark.size()) == mark)
      return line.substr(mark.size());
  return std::nullopt;
}

/// Whether the line is a point if commas are decimal points.
bool hasDecimalCommas(std::string_view line)
{
  std::string with_points(line);
  std::replace(with_points.begin(), with_points.end(), ',', '.');
  return with_points != line && startsWithPoint(columnsOf(with_points));
}

/// Whether float loses digits of the points that it would have near the origin.
bool areFarFromOrigin(std::vector<std::array<double, 3>> points)
{
  const auto isFinite = [](const auto& point) {
    return std::all_of(point.begin(), point.end(), [](double value) { return std::isfinite(value); });
  };
  points.erase(std::partition(points.begin(), points.end(), isFinite), points.end());
  const CloudScale scale = scaleOf(points);
  constexpr double far = 16; // times its size: four of float's 24 bits
  return scale.magnitude > far * scale.extent;
}

class Reader : LineReader {
public:
  using LineReader::LineReader;

  Cloud read()
  {
    readStart();
    readPoints();
    return cloud();
  }

private:
  using Point = std::array<double, 3>;
  static constexpr int ignored = -1;

  [[noreturn]] void fail(const std::string& why) const
  {
    throw inputFailure(path_, "line " + std::to_string(line_number_) + ": " + why);
  }

  std::string decimalAdvice() const { return "; its commas look like decimal commas: " + filtered("tr , .", path_); }

  /// Takes lines up to one that is neither blank nor a comment, which is kept in case it names the columns.
  /// \return whether there is one
  bool takeLine()
  {
    while (!rest_.empty()) {
      line_ = nextLine(rest_, line_end_);
      ++line_number_;
      if (const auto comment = commentIn(line_))
        comment_ = *comment;
      else if (!trimmed(line_).empty())
        return true;
    }
    return false;
  }

  /// Up to the first point.
  void readStart()
  {
    has_line_ = takeLine();
    if (!has_line_)
      return;
    std::vector<std::string_view> columns = columnsOf(line_);
    if (columns.size() == 1) {
      promised_ = parseNumber<std::size_t>(columns[0]);
      if (promised_) {
        has_line_ = takeLine();
        columns = columnsOf(has_line_ ? line_ : "");
      }
    }
    if (has_line_ && takeNames(columns)) {
      names_are_given_ = true;
      has_line_ = takeLine();
    }
    if (has_line_)
      readLayout();
  }

  /// The order of the columns, where these are their names.
  bool takeNames(const std::vector<std::string_view>& columns)
  {
    std::vector<int> axis_of(columns.size(), ignored);
    std::array<int, 3> found{};
    for (std::size_t i = 0; i < columns.size(); ++i) {
      std::string_view name = columns[i];
      if (name.size() > 2 && name.front() == '"' && name.back() == '"')
        name = trimmed(name.substr(1, name.size() - 2));
      for (int axis = 0; axis < 3; ++axis)
        if (name.size() == 1 && std::tolower(static_cast<unsigned char>(name[0])) == "xyz"[axis]) {
          axis_of[i] = axis;
          ++found[axis];
        }
    }
    if (std::any_of(found.begin(), found.end(), [](int times) { return times == 0; }))
      return false;
    for (int axis = 0; axis < 3; ++axis)
      if (found[axis] > 1)
        fail(std::string("names the column ") + "xyz"[axis] + " twice");
    axis_of_ = std::move(axis_of);
    return true;
  }

  /// What the first point has.
  void readLayout()
  {
    separator_ = separatorOf(line_);
    const std::vector<std::string_view> columns = columnsOf(line_);
    if (names_are_given_)
      return;
    const std::vector<std::string_view> names = columnsOf(comment_);
    if (names.size() == columns.size() && takeNames(names))
      return;
    if (!startsWithPoint(columns))
      throw inputFailure(
          path_,
          "is not a PCD or PLY file, and for a text of points its line " + std::to_string(line_number_) +
              " has neither three numbers nor the names x, y and z" +
              (hasDecimalCommas(line_) ? decimalAdvice() : ": '" + std::string(trimmed(line_).substr(0, 40)) + "'"));
    axis_of_.assign(columns.size(), ignored);
    for (int axis = 0; axis < 3; ++axis)
      axis_of_[axis] = axis;
    const bool is_pts = promised_.has_value(); // which has x, y and z first
    if (columns.size() > 3 && !is_pts)
      warnings_.push_back(path_ + ": its " + std::to_string(columns.size()) +
                          " columns have no names; the first three are taken as x, y and z");
  }

  void readPoints()
  {
    for (; has_line_; has_line_ = takeLine())
      points_.push_back(readPoint());
    if (promised_ && *promised_ != points_.size())
      throw inputFailure(path_,
                         "its first line promises " + std::to_string(*promised_) + " points; there are " +
                             std::to_string(points_.size()));
  }

  Point readPoint() const
  {
    Point point{};
    Columns columns(line_, separator_);
    std::size_t count = 0;
    for (auto column = columns.next(); column; column = columns.next(), ++count)
      if (count < axis_of_.size() && axis_of_[count] != ignored)
        point[axis_of_[count]] = readCoordinate(*column, "xyz"[axis_of_[count]]);
    if (count == axis_of_.size())
      return point;
    const bool is_twice = separator_ == ',' && count == 2 * axis_of_.size();
    fail("has " + std::to_string(count) + " columns where the lines before have " + std::to_string(axis_of_.size()) +
         (is_twice || hasDecimalCommas(line_) ? decimalAdvice() : ""));
  }

  double readCoordinate(std::string_view text, char axis) const
  {
    if (const auto value = parseCoordinate(text))
      return *value;
    fail(std::string(1, axis) +
         (text.empty() ? " is missing" : ": '" + std::string(text.substr(0, 40)) + "' is not a number") +
         (hasDecimalCommas(line_) || hasDecimalCommas(std::string(text) + " 0 0") ? decimalAdvice() : ""));
  }

  Cloud cloud()
  {
    Cloud cloud;
    const bool are_far = areFarFromOrigin(points_);
    addCoordinates(cloud, path_, are_far ? pcl::PCLPointField::FLOAT64 : pcl::PCLPointField::FLOAT32);
    cloud.setSize(points_.size(), 1, path_);
    cloud.data.data.resize(cloud.size() * cloud.data.point_step);
    const auto xyz = VectorField::find(cloud, {"x", "y", "z"});
    std::uint8_t* to = cloud.data.data.data();
    for (const Point& point : points_) {
      xyz->set(to, point);
      to += cloud.data.point_step;
    }
    cloud.warnings = std::move(warnings_);
    return cloud;
  }

  std::string_view line_;
  std::size_t line_number_ = 0;
  bool has_line_ = false;
  std::string_view comment_; ///< the last one so far
  std::optional<std::size_t> promised_;
  bool names_are_given_ = false;
  char separator_ = ' ';
  std::vector<int> axis_of_; ///< by column
  std::vector<Point> points_;
  Warnings warnings_;
};

} // namespace

Cloud readTextCloud(const std::string& path, std::string_view content) { return Reader(path, content).read(); }

} // namespace pcl_gpu_icp::cli
