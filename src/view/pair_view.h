#pragma once

#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace pcl_gpu_icp::view {

/// A cloud of which a view is made. Its points are finite, about an origin that is in the coordinates of its file.
struct Cloud {
  Points points;
  std::array<double, 3> origin{};
};

/// A pose of the source, from file to file.
struct NamedPose {
  std::string name;
  RigidTransform transform;
};

/// What is shown of a cloud: points drawn from it at random, the same each time.
struct ShownCloud {
  std::array<double, 3> centre{}; ///< the median of each coordinate, in the coordinates of the file
  std::vector<float> xyz;         ///< about that, one point after the other
  std::size_t all = 0;            ///< points of which they were drawn

  std::size_t size() const { return xyz.size() / 3; }
};

struct ShownPose {
  std::string name;
  RigidTransform transform;     ///< from about the source's centre to about the target's
  std::vector<float> distances; ///< of each source point shown to the nearest of all target points
};

/// Lowest and highest coordinates, about the target's centre.
struct Box {
  std::array<double, 3> low{}, high{};
};

struct PairView {
  ShownCloud source, target;
  std::vector<ShownPose> poses; ///< the first is where the source lay, the others where it was put
};

/// \param most points to show of each cloud
PairView viewOf(const Cloud& source, const Cloud& target, const std::vector<NamedPose>& poses, std::size_t most);

/// Around the target and the source at a pose, but for the few points that lie far out.
Box frameOf(const PairView& view, const ShownPose& pose);

/// The middle one by size of any values but none.
double medianOf(std::vector<float> values);

} // namespace pcl_gpu_icp::view
