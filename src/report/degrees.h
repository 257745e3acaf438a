#pragma once

namespace pcl_gpu_icp::report {

constexpr double degrees_per_radian = 57.295779513082320877;
constexpr double radians_per_degree = 0.017453292519943295769;

} // namespace pcl_gpu_icp::report
