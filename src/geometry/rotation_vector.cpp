#include "rotation_vector.h"

#include <cmath>

namespace pcl_gpu_icp {

std::array<double, 3> rotationVector(const std::array<double, 9>& r)
{
  const std::array<double, 3> twice_sine_axis{r[7] - r[5], r[2] - r[6], r[3] - r[1]};
  const double twice_sine = std::hypot(twice_sine_axis[0], twice_sine_axis[1], twice_sine_axis[2]);
  const double angle = std::atan2(twice_sine, r[0] + r[4] + r[8] - 1);
  const double factor = twice_sine > 0 ? angle / twice_sine : 0;
  return {factor * twice_sine_axis[0], factor * twice_sine_axis[1], factor * twice_sine_axis[2]};
}

std::array<double, 9> rotationBy(const std::array<double, 3>& v)
{
  const double angle = std::hypot(v[0], v[1], v[2]);
  const double half = angle / 2;
  const double a = angle > 0 ? std::sin(angle) / angle : 1;
  const double b = angle > 0 ? std::sin(half) * std::sin(half) / (half * half) / 2 : 0.5;
  const std::array<double, 9> cross{0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0};
  std::array<double, 9> rotation{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      rotation[3 * i + j] = (i == j ? 1 - b * angle * angle : 0) + a * cross[3 * i + j] + b * v[i] * v[j];
  return rotation;
}

} // namespace pcl_gpu_icp
