#pragma once

#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <array>
#include <cstddef>
#include <vector>

namespace pcl_gpu_icp {

using Place = std::array<double, 3>;

constexpr double near_spacings = 3; ///< how far from a cloud is near

/// At most so many, one of each stretch of the cloud, anywhere in it, so that no pattern of the cloud's order decides.
std::vector<PlacedPoint> thinned(const Points& cloud, std::size_t most, const Place& pivot = {});

std::vector<Place> placesOf(const std::vector<PlacedPoint>& points, const RigidTransform& pose = {});

double share(std::size_t part, std::size_t whole);

/// Infinite for none.
double medianOf(std::vector<double> values);

/// Some points of a cloud, and fewer of them.
struct SampledCloud {
  /// \param threads on the host
  SampledCloud(const Points& all, const Place& at, unsigned threads);

  Place pivot; ///< of the points
  std::vector<PlacedPoint> points, samples;
  double spacing = 0; ///< of the points; 0: there are too few, or all at one place
};

} // namespace pcl_gpu_icp
