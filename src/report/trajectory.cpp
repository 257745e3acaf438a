#include "report/trajectory.h"

#include "report/format.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pcl_gpu_icp::report {
namespace {

/// x, y, z, w of a rotation, w not negative.
std::array<double, 4> quaternion(const std::array<double, 9>& r)
{
  // Four times the square of each. The largest is divided by, so that no digits are lost.
  const std::array<double, 4> squares{1 + r[0] - r[4] - r[8], //
                                      1 - r[0] + r[4] - r[8],
                                      1 - r[0] - r[4] + r[8],
                                      1 + r[0] + r[4] + r[8]};
  const auto largest = std::max_element(squares.begin(), squares.end()) - squares.begin();
  const double twice = std::sqrt(squares[largest]);
  const double xy = r[1] + r[3], xz = r[2] + r[6], yz = r[5] + r[7];
  const double xw = r[7] - r[5], yw = r[2] - r[6], zw = r[3] - r[1];
  const std::array<std::array<double, 4>, 4> products{
      {{squares[0], xy, xz, xw}, {xy, squares[1], yz, yw}, {xz, yz, squares[2], zw}, {xw, yw, zw, squares[3]}}};
  std::array<double, 4> q;
  const double sign = products[largest][3] < 0 ? -1 : 1;
  for (int i = 0; i < 4; ++i)
    q[i] = sign * products[largest][i] / (2 * twice);
  return q;
}

} // namespace

std::string kittiText(const Trajectory& trajectory)
{
  std::string text;
  for (const RigidTransform& pose : trajectory.poses()) {
    const auto& r = pose.rotation;
    const auto& t = pose.translation;
    for (std::size_t row = 0; row < 3; ++row)
      text +=
          format("%.17g %.17g %.17g %.17g%c", r[3 * row], r[3 * row + 1], r[3 * row + 2], t[row], row < 2 ? ' ' : '\n');
  }
  return text;
}

std::string tumText(const Trajectory& trajectory)
{
  std::string text;
  std::size_t number = 0;
  for (const RigidTransform& pose : trajectory.poses()) {
    const auto& t = pose.translation;
    const auto q = quaternion(pose.rotation);
    text +=
        format("%zu %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", number++, t[0], t[1], t[2], q[0], q[1], q[2], q[3]);
  }
  return text;
}

} // namespace pcl_gpu_icp::report
