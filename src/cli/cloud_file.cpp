#include "cli/cloud_file.h"

#include "cli/foreign_file.h"
#include "cli/input_file.h"
#include "cli/kitti_scan.h"
#include "cli/las.h"
#include "cli/lower_case.h"
#include "cli/number.h"
#include "cli/pcd.h"
#include "cli/ply.h"
#include "cli/text_cloud.h"
#include "cli/vtk.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace pcl_gpu_icp::cli {
namespace {

/// Behind blank lines.
bool isPly(std::string_view content)
{
  const char end = lineEnd(content.substr(std::min(content.find_first_not_of("\r\n"), content.size())));
  while (!content.empty()) {
    std::string_view line = nextLine(content, end);
    const std::string word = lowerCase(nextWord(line));
    if (!word.empty())
      return word == "ply" && nextWord(line).empty();
  }
  return false;
}

/// Its header may have anything before the line that says what it is.
bool isPcd(std::string_view content)
{
  constexpr std::size_t longest_start = 1 << 16;
  content = content.substr(0, longest_start);
  const char end = lineEnd(content);
  while (!content.empty()) {
    std::string_view line = nextLine(content, end);
    const std::string_view whole = line;
    const std::string word = lowerCase(nextWord(line));
    if (word == "fields" || word == "columns" ||
        (!word.empty() && word[0] == '#' && whole.find(".PCD v") != std::string_view::npos))
      return true;
  }
  return false;
}

std::string extensionOf(const std::string& path) { return lowerCase(std::filesystem::path(path).extension().string()); }

} // namespace

std::optional<CloudFormat> formatOf(const std::string& path)
{
  const std::string extension = extensionOf(path);
  if (extension == ".pcd")
    return CloudFormat::Pcd;
  if (extension == ".ply")
    return CloudFormat::Ply;
  return std::nullopt;
}

Cloud readCloud(const std::string& path) { return parseCloud(path, readFile(path)); }

Cloud readCloudArgument(const std::string& argument)
{
  return argument == standard_input ? parseCloud(argument, readStandardInput()) : readCloud(argument);
}

Cloud parseCloud(const std::string& path, std::string_view content)
{
  if (content.empty())
    throw inputFailure(path, "is empty");
  content = withoutByteOrderMark(content);
  if (isPly(content))
    return readPly(path, content);
  if (isPcd(content))
    return readPcd(path, content);
  if (isVtk(content))
    return readVtk(path, content);
  if (isLas(content))
    return readLas(path, content);
  // Before what starts with bytes of its own, as any number may.
  if (extensionOf(path) == ".bin" && looksBinary(content))
    return readKittiScan(path, content);
  if (const auto foreign = describeForeign(path, content))
    throw inputFailure(path, *foreign);
  return readTextCloud(path, content);
}

Warnings checkWritable(const Cloud& cloud, const std::string& path)
{
  if (formatOf(path) == CloudFormat::Ply) {
    try {
      plyHeader(cloud);
    } catch (const Failure& failure) {
      throw Failure(failure.code(), path + ": " + failure.what());
    }
    const auto& fields = cloud.data.fields;
    const bool has_padding = std::any_of(
        fields.begin(), fields.end(), [](const pcl::PCLPointField& field) { return field.name == padding; });
    return has_padding ? Warnings{path + ": PLY has no padding; the fields _ are left out"} : Warnings{};
  }
  std::string left_out;
  for (const OtherElement& element : cloud.elements)
    if (!element.pose_at && element.count > 0)
      left_out += (left_out.empty() ? "" : ", ") + std::to_string(element.count) + " of element " + element.name;
  return left_out.empty() ? Warnings{} : Warnings{path + ": PCD holds points only; left out: " + left_out};
}

std::string writeCloud(const Cloud& cloud, CloudFormat format)
{
  return format == CloudFormat::Ply ? writePly(cloud) : writePcd(cloud);
}

} // namespace pcl_gpu_icp::cli
