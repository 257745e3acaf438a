#pragma once

#include <pcl_gpu_icp/rigid_transform.h>

#include <array>

namespace pcl_gpu_icp::report {

struct Difference {
  double degrees = 0; ///< angle of the rotation from one transform to the other
  double metres = 0;  ///< distance between the two images of the source's centroid, in the unit of the files
};

Difference differenceOf(const RigidTransform& a, const RigidTransform& b, const std::array<double, 3>& centroid);

} // namespace pcl_gpu_icp::report
