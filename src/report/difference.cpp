#include "report/difference.h"

#include "report/degrees.h"

#include <cmath>

namespace pcl_gpu_icp::report {

Difference differenceOf(const RigidTransform& a, const RigidTransform& b, const std::array<double, 3>& centroid)
{
  // |A - B|_F = 2 sqrt(2) sin(angle / 2) keeps its digits at small angles, where the trace loses them.
  double squared = 0;
  for (int i = 0; i < 9; ++i)
    squared += (a.rotation[i] - b.rotation[i]) * (a.rotation[i] - b.rotation[i]);
  const auto image_a = a(centroid[0], centroid[1], centroid[2]);
  const auto image_b = b(centroid[0], centroid[1], centroid[2]);
  return {2 * std::asin(std::fmin(1.0, std::sqrt(squared / 8))) * degrees_per_radian,
          std::hypot(image_a[0] - image_b[0], image_a[1] - image_b[1], image_a[2] - image_b[2])};
}

} // namespace pcl_gpu_icp::report
