#include "report/matrix.h"

#include "report/degrees.h"
#include "report/format.h"

#include <Eigen/Geometry>

#include <cmath>

namespace pcl_gpu_icp::report {
Matrix4 toMatrix(const RigidTransform& transform)
{
  const auto& r = transform.rotation;
  const auto& t = transform.translation;
  return {{{r[0], r[1], r[2], t[0]}, {r[3], r[4], r[5], t[1]}, {r[6], r[7], r[8], t[2]}, {0, 0, 0, 1}}};
}

std::string matrixFile(const RigidTransform& transform)
{
  std::string text;
  for (const auto& row : toMatrix(transform))
    text += format("%.17g %.17g %.17g %.17g\n", row[0], row[1], row[2], row[3]);
  return text;
}

std::string matrixText(const RigidTransform& transform)
{
  constexpr double last_digit = 1e10;
  const auto entry = [](double value) { return std::round(value * last_digit) / last_digit + 0.0; }; // no -0.0
  std::string text;
  for (const auto& row : toMatrix(transform))
    text += format(
        "           %13.10f %13.10f %13.10f %16.9g\n", entry(row[0]), entry(row[1]), entry(row[2]), row[3] + 0.0);
  return text;
}

std::string motionText(const RigidTransform& transform, const std::array<double, 3>& centroid)
{
  constexpr double mostly = 10;
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(transform.rotation.data());
  const Eigen::AngleAxisd turn{Eigen::Matrix3d(rotation)};
  const Eigen::Map<const Eigen::Vector3d> of_origin(transform.translation.data()), middle(centroid.data());
  const Eigen::Vector3d of_middle = rotation * middle + of_origin - middle;
  const bool is_far = of_origin.norm() > mostly * of_middle.norm();
  const Eigen::Vector3d& shift = is_far ? of_middle : of_origin;
  const double degrees = turn.angle() * degrees_per_radian;
  std::string text = format("shifts %sby %.6g", is_far ? "the source's middle " : "", shift.norm());
  if (shift.norm() > 0) {
    const Eigen::Vector3d along = shift.normalized();
    text += " " + directionText("along", {along.x(), along.y(), along.z()});
  }
  text += format(", turns by %.6g degrees", degrees);
  return degrees > 0 ? text + " " + directionText("about", {turn.axis().x(), turn.axis().y(), turn.axis().z()}) : text;
}

} // namespace pcl_gpu_icp::report
