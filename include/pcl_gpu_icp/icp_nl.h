#pragma once

#include <pcl_gpu_icp/device_icp.h>

#include <pcl/registration/icp_nl.h>

namespace pcl_gpu_icp {

/// pcl::IterativeClosestPointNonLinear on an OpenCL device. The squared distances that its Levenberg-Marquardt
/// optimiser makes least have a closed solution: the five stages. Everything else as in
/// pcl_gpu_icp::IterativeClosestPoint.
template <typename PointSource, typename PointTarget, typename Scalar = float>
class IterativeClosestPointNonLinear
: public DeviceIcp<pcl::IterativeClosestPointNonLinear<PointSource, PointTarget, Scalar>> {
public:
  using Ptr = pcl::shared_ptr<IterativeClosestPointNonLinear>;
  using ConstPtr = pcl::shared_ptr<const IterativeClosestPointNonLinear>;
};

} // namespace pcl_gpu_icp
