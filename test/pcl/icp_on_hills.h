#pragma once

#include "parity.h"

#include <limits>

using pcl::PointXYZ;
using Cloud = pcl::PointCloud<PointXYZ>;
using Icp = pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ>;

inline const float not_a_number = std::numeric_limits<float>::quiet_NaN();
inline const Eigen::Matrix4f identity = Eigen::Matrix4f::Identity();
inline const auto twenty_iterations = [](auto& icp) { icp.setMaximumIterations(20); };

/// A pair of hilly clouds, a small motion apart, and an aligner.
class IcpOnHills : public testing::Test {
protected:
  Cloud::Ptr target = scenes::hills<PointXYZ>(3000);
  Cloud::Ptr source = scenes::moved(*scenes::hills<PointXYZ>(2500, 2), scenes::smallMotion());
  Icp icp;
};
