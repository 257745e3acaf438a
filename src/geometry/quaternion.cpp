#include "quaternion.h"

namespace pcl_gpu_icp {

std::array<double, 9> rotationOf(const std::array<double, 4>& quaternion)
{
  const auto [w, x, y, z] = quaternion;
  return {1 - 2 * (y * y + z * z),
          2 * (x * y - w * z),
          2 * (x * z + w * y),
          2 * (x * y + w * z),
          1 - 2 * (x * x + z * z),
          2 * (y * z - w * x),
          2 * (x * z - w * y),
          2 * (y * z + w * x),
          1 - 2 * (x * x + y * y)};
}

} // namespace pcl_gpu_icp
