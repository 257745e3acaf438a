#pragma once

#include <pcl_gpu_icp/export.h>
#include <pcl_gpu_icp/normal_estimator.h>

#include <array>
#include <cstddef>
#include <vector>

namespace pcl_gpu_icp {

/// Symmetric 3x3: xx xy xz yy yz zz.
using PointCovariances = std::vector<std::array<float, 6>>;

/// What the covariance of a point on a surface has along its normal, for 1 within: PCL's GICP.
constexpr double surface_epsilon = 0.001;

/// Covariances of points on a surface (Segal, Haehnel and Thrun 2009): 1 within it and `epsilon` along its normal,
/// I - (1 - epsilon) n n^T; where there is no normal I.
/// \param normals unit vectors of either sign; NaN: none
PCL_GPU_ICP_API PointCovariances surfaceCovariances(const NormalEstimator::Normals& normals, double epsilon);

/// \param points how many at least must have one
/// \param whose "source" or "target", for the message
/// \throws InvalidArgument where there are too few, or one is not finite or has a negative eigenvalue
PCL_GPU_ICP_API void requireCovariances(const PointCovariances& covariances, std::size_t points, const char* whose);

} // namespace pcl_gpu_icp
