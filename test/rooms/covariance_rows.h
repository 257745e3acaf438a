#pragma once

#include <pcl_gpu_icp/point_covariances.h>
#include <pcl_gpu_icp/points.h>

#include <Eigen/Core>

#include <vector>

namespace pcl_gpu_icp::test {

using Matrices = std::vector<Eigen::Matrix3d>;

/// Covariances as the library takes them.
inline PointCovariances inRows(const Matrices& matrices)
{
  PointCovariances rows;
  for (const Eigen::Matrix3d& m : matrices) {
    const Eigen::Matrix3f f = m.cast<float>();
    rows.push_back({f(0, 0), f(0, 1), f(0, 2), f(1, 1), f(1, 2), f(2, 2)});
  }
  return rows;
}

inline Points viewOfRows(const PointCovariances& rows) { return {rows.data(), rows.size(), sizeof(rows[0])}; }

} // namespace pcl_gpu_icp::test
