#include "cli/coloured_cloud.h"

#include "cli/failure.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace pcl_gpu_icp::cli {
namespace {

using Point = std::array<double, 3>;

bool isLeftOut(const Point& point, const ColouredPart& part)
{
  return !std::all_of(point.begin(), point.end(), [](double value) { return std::isfinite(value); }) ||
         (part.without_zero_returns && point == Point{});
}

} // namespace

Cloud colouredCloud(const std::vector<ColouredPart>& parts, const std::string& path)
{
  std::vector<std::pair<Point, std::uint32_t>> points;
  bool is_double = false;
  for (const ColouredPart& part : parts) {
    const Coordinates from = coordinates(part.cloud, part.path);
    is_double = is_double || from.from_double;
    points.reserve(points.size() + from.points.size());
    for (const Point& point : from.points)
      if (!isLeftOut(point, part))
        points.emplace_back(part.transform(point[0], point[1], point[2]), part.colour);
  }

  Cloud cloud;
  addCoordinates(cloud, path, is_double ? pcl::PCLPointField::FLOAT64 : pcl::PCLPointField::FLOAT32);
  addField(cloud, path, "rgb", pcl::PCLPointField::FLOAT32);
  const std::size_t step = cloud.data.point_step, most_bytes = std::numeric_limits<std::uint32_t>::max();
  if (points.size() > most_bytes / step)
    throw Failure(ExitCode::Output, path + ": the points of both clouds are more than 4 GiB");
  cloud.setSize(points.size(), 1, path);
  cloud.data.data.resize(points.size() * step);
  const auto xyz = VectorField::find(cloud, {"x", "y", "z"});
  std::uint8_t* to = cloud.data.data.data();
  for (const auto& [point, colour] : points) {
    xyz->set(to, point);
    std::memcpy(to + step - sizeof colour, &colour, sizeof colour);
    to += step;
  }
  return cloud;
}

} // namespace pcl_gpu_icp::cli
