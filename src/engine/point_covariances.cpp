#include <pcl_gpu_icp/point_covariances.h>

#include <cmath>

namespace pcl_gpu_icp {

PointCovariances surfaceCovariances(const NormalEstimator::Normals& normals, double epsilon)
{
  PointCovariances covariances;
  covariances.reserve(normals.size());
  for (const auto& normal : normals) {
    const bool exists = std::isfinite(normal[0]) && std::isfinite(normal[1]) && std::isfinite(normal[2]);
    const double share = exists ? 1 - epsilon : 0;
    const double x = exists ? normal[0] : 0, y = exists ? normal[1] : 0, z = exists ? normal[2] : 0;
    covariances.push_back({static_cast<float>(1 - share * x * x),
                           static_cast<float>(-share * x * y),
                           static_cast<float>(-share * x * z),
                           static_cast<float>(1 - share * y * y),
                           static_cast<float>(-share * y * z),
                           static_cast<float>(1 - share * z * z)});
  }
  return covariances;
}

} // namespace pcl_gpu_icp
