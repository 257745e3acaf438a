#include "cli/cloud_file.h"

#include "cli/input_file.h"
#include "cli/pcd.h"
#include "cli/ply.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace pcl_gpu_icp::cli {

std::optional<CloudFormat> formatOf(const std::string& path)
{
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(
      extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return std::tolower(c); });
  if (extension == ".pcd")
    return CloudFormat::Pcd;
  if (extension == ".ply")
    return CloudFormat::Ply;
  return std::nullopt;
}

Cloud readCloud(const std::string& path)
{
  const std::string content = readFile(path);
  if (content.empty())
    throw inputFailure(path, "is empty");
  const std::string start = content.substr(0, 4);
  return start == "ply\n" || start == "ply\r" ? readPly(path, content) : readPcd(path, content);
}

void checkWritable(const Cloud& cloud, CloudFormat format)
{
  if (format == CloudFormat::Ply)
    plyHeader(cloud);
}

std::string writeCloud(const Cloud& cloud, CloudFormat format)
{
  return format == CloudFormat::Ply ? writePly(cloud) : writePcd(cloud);
}

} // namespace pcl_gpu_icp::cli
