#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pcl_gpu_icp::cli {

/// How large a cloud is and how far from the origin, whatever a few stray points say.
struct CloudScale {
  double extent = 0;    ///< of the longest side of a box about nine tenths of the points
  double magnitude = 0; ///< the largest coordinate in that box
  std::size_t points = 0;

  /// Between neighbours, as of points spread over a surface.
  double spacing() const;
};

/// \param points finite; a few thousand of them are looked at
CloudScale scaleOf(const std::vector<std::array<double, 3>>& points);

/// Where float32 coordinates of that magnitude are coarse against the spacing of the points.
std::optional<std::string> coarseCoordinates(const CloudScale& scale, const std::string& path);

/// Where two clouds can hardly be in the same unit.
std::optional<std::string> unlikeUnits(const CloudScale& source,
                                       const std::string& source_path,
                                       const CloudScale& target,
                                       const std::string& target_path);

/// Where so many points are at exactly (0, 0, 0) that they are no measurements.
std::optional<std::string> zeroReturns(const std::vector<std::array<double, 3>>& points, const std::string& path);

} // namespace pcl_gpu_icp::cli
