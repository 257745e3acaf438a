#include "cli/prepared_cloud.h"

#include "cli/cloud_file.h"
#include "cli/input_file.h"

#include <pcl_gpu_icp/icp_loop.h>
#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/search/points_of.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace pcl_gpu_icp::cli {
namespace {

using Point = std::array<double, 3>;

bool isFinite(const Point& point)
{
  return std::all_of(point.begin(), point.end(), [](double value) { return std::isfinite(value); });
}

template <typename Condition>
std::size_t removeWhere(std::vector<Point>& points, Condition condition)
{
  const auto end = std::remove_if(points.begin(), points.end(), condition);
  const auto removed = static_cast<std::size_t>(points.end() - end);
  points.erase(end, points.end());
  return removed;
}

/// The median of each coordinate: a few points far from the others do not move it.
Point middle(const std::vector<Point>& points)
{
  Point result;
  std::vector<double> values(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(points.begin(), points.end(), values.begin(), [axis](const Point& point) { return point[axis]; });
    const auto median = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), median, values.end());
    result[axis] = *median;
  }
  return result;
}

Point centroid(const std::vector<Point>& points, const Point& origin)
{
  Point sum{};
  for (const Point& point : points)
    for (int axis = 0; axis < 3; ++axis)
      sum[axis] += point[axis] - origin[axis];
  for (int axis = 0; axis < 3; ++axis)
    sum[axis] = origin[axis] + sum[axis] / static_cast<double>(points.size());
  return sum;
}

/// As pcl::VoxelGrid, but in double and without its limit of 2^31 voxels in the bounding box.
std::vector<Point> voxelCentroids(const std::vector<Point>& points, double leaf, const std::string& path)
{
  struct Entry {
    std::array<std::int64_t, 3> voxel; // z, y, x: VoxelGrid's order
    std::uint32_t point;
  };
  constexpr double most = 9e15; // where double still has every whole number
  std::vector<Entry> entries(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double index = std::floor(points[i][axis] / leaf);
      if (!(std::abs(index) < most))
        throw Failure(ExitCode::Usage, "--leaf: too small for the coordinates of " + path);
      entries[i].voxel[2 - axis] = static_cast<std::int64_t>(index);
    }
    entries[i].point = static_cast<std::uint32_t>(i);
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.voxel != b.voxel ? a.voxel < b.voxel : a.point < b.point;
  });

  std::vector<Point> centroids;
  std::vector<Point> members;
  for (auto first = entries.begin(); first != entries.end();) {
    members.clear();
    auto next = first;
    for (; next != entries.end() && next->voxel == first->voxel; ++next)
      members.push_back(points[next->point]);
    centroids.push_back(centroid(members, members.front()));
    first = next;
  }
  return centroids;
}

} // namespace

PreparedCloud prepare(const Cloud& cloud, const std::string& path, const AlignmentOptions& options)
{
  auto [points, from_double] = coordinates(cloud, path);
  PreparedCloud result;
  result.warnings = cloud.warnings;
  auto& counts = result.counts;
  counts.in_file = points.size();
  counts.non_finite = removeWhere(points, [](const Point& point) { return !isFinite(point); });
  const auto warning = zeroReturns(points, path);
  if (warning && !options.drop_zero_returns)
    result.warnings.push_back(*warning);
  if (options.drop_zero_returns.value_or(warning.has_value()))
    counts.zero_returns = removeWhere(points, [](const Point& point) { return point == Point{}; });
  if (from_double && !points.empty()) {
    // What float cannot hold about the middle of the cloud would become infinite.
    result.origin = middle(points);
    counts.non_finite += removeWhere(points, [origin = result.origin](const Point& point) {
      for (int axis = 0; axis < 3; ++axis)
        if (!std::isfinite(static_cast<float>(point[axis] - origin[axis])))
          return true;
      return false;
    });
  }
  counts.too_large = removeWhere(points, [origin = result.origin](const Point& point) {
    const float about[3] = {static_cast<float>(point[0] - origin[0]),
                            static_cast<float>(point[1] - origin[1]),
                            static_cast<float>(point[2] - origin[2])};
    return !takesPart(about);
  });
  if (points.empty())
    throw inputFailure(path,
                       "has no usable points: of " + std::to_string(counts.in_file) + ", " +
                           std::to_string(counts.non_finite) + " are not finite, " + std::to_string(counts.too_large) +
                           " are beyond 1e18 and " + std::to_string(counts.zero_returns) + " are zero returns");
  result.scale = scaleOf(points);
  if (!from_double)
    if (const auto warning = coarseCoordinates(result.scale, path))
      result.warnings.push_back(*warning);
  if (options.leaf) {
    const std::size_t before = points.size();
    points = voxelCentroids(points, *options.leaf, path);
    counts.downsampled = before - points.size();
  }
  counts.used = points.size();

  result.points = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  result.points->reserve(points.size());
  const auto& origin = result.origin;
  for (const Point& point : points)
    result.points->emplace_back(static_cast<float>(point[0] - origin[0]),
                                static_cast<float>(point[1] - origin[1]),
                                static_cast<float>(point[2] - origin[2]));
  const Lever lever = leverOf(search::pointsOf(*result.points));
  for (int axis = 0; axis < 3; ++axis)
    result.centroid[axis] = origin[axis] + lever.centre[axis];
  result.extent = 2 * lever.length;
  return result;
}

std::shared_ptr<const PreparedCloud> readPrepared(const std::string& path, const AlignmentOptions& options)
{
  return std::make_shared<const PreparedCloud>(prepare(readCloud(path), path, options));
}

} // namespace pcl_gpu_icp::cli
