#pragma once

#include <pcl_gpu_icp/rigid_transform.h>

#include <string>
#include <vector>

namespace pcl_gpu_icp::report {

/// Where the scans of a sequence are, in the frame of the first.
class Trajectory {
public:
  /// Appends the next scan.
  /// \param onto_last what moves it onto the one before
  void add(const RigidTransform& onto_last) { poses_.push_back(compose(poses_.back(), onto_last)); }

  const std::vector<RigidTransform>& poses() const { return poses_; }

private:
  std::vector<RigidTransform> poses_{RigidTransform()};
};

/// A line for each pose: the 12 numbers of its upper three rows.
std::string kittiText(const Trajectory& trajectory);

/// A line for each pose: its number as the timestamp, tx ty tz, qx qy qz qw.
std::string tumText(const Trajectory& trajectory);

} // namespace pcl_gpu_icp::report
