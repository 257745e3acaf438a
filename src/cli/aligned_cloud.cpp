#include "cli/aligned_cloud.h"

#include <cmath>
#include <cstring>

namespace pcl_gpu_icp::cli {
namespace {

using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Rows rotationOf(const RigidTransform& transform)
{
  Rows rows;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      rows(row, column) = transform.rotation[3 * row + column];
  return rows;
}

void movePose(Cloud& cloud, const RigidTransform& transform)
{
  const auto place = transform(cloud.sensor_origin.x(), cloud.sensor_origin.y(), cloud.sensor_origin.z());
  for (int axis = 0; axis < 3; ++axis)
    cloud.sensor_origin[axis] = static_cast<float>(place[axis]);
  const Eigen::Quaterniond turn{Eigen::Matrix3d(rotationOf(transform))};
  cloud.sensor_orientation = (turn * cloud.sensor_orientation.cast<double>()).cast<float>();
}

/// In the element itself, whose other values stay.
void moveCamera(OtherElement& camera, const RigidTransform& transform)
{
  float pose[12];
  char* const bytes = camera.body.data() + *camera.pose_at;
  std::memcpy(pose, bytes, sizeof pose);
  const auto place = transform(pose[0], pose[1], pose[2]);
  for (int axis = 0; axis < 3; ++axis)
    pose[axis] = static_cast<float>(place[axis]);
  Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> rows(pose + 3);
  rows = (rotationOf(transform) * rows.cast<double>()).cast<float>().eval();
  std::memcpy(bytes, pose, sizeof pose);
}

} // namespace

void transform(Cloud& cloud, const RigidTransform& transform, bool keep_zero_returns)
{
  const auto xyz = VectorField::find(cloud, {"x", "y", "z"});
  auto normal = VectorField::find(cloud, {"normal_x", "normal_y", "normal_z"});
  if (!normal)
    normal = VectorField::find(cloud, {"nx", "ny", "nz"});
  const RigidTransform turn{transform.rotation, {0, 0, 0}};

  std::uint8_t* point = cloud.data.data.data();
  for (std::size_t i = 0; i < cloud.size(); ++i, point += cloud.data.point_step) {
    const auto p = xyz->get(point);
    // As stock PCL leaves them.
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
      continue;
    if (keep_zero_returns && p == std::array<double, 3>{})
      continue;
    xyz->set(point, transform(p[0], p[1], p[2]));
    if (!normal)
      continue;
    const auto n = normal->get(point);
    normal->set(point, turn(n[0], n[1], n[2]));
  }
  movePose(cloud, transform);
  for (OtherElement& element : cloud.elements)
    if (element.pose_at)
      moveCamera(element, transform);
}

} // namespace pcl_gpu_icp::cli
