#include <pcl_gpu_icp/point_covariances.h>

#include <pcl_gpu_icp/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace pcl_gpu_icp {

namespace {

bool isFinite(const std::array<float, 6>& covariance)
{
  return std::all_of(covariance.begin(), covariance.end(), [](float value) { return std::isfinite(value); });
}

/// Whether no eigenvalue is negative but for float's rounding of the entries: no principal minor is.
bool isSemidefinite(const std::array<float, 6>& covariance)
{
  const double size = std::max({std::abs(covariance[0]), std::abs(covariance[3]), std::abs(covariance[5])});
  if (size == 0)
    return std::all_of(covariance.begin(), covariance.end(), [](float value) { return value == 0; });
  std::array<double, 6> c{};
  std::transform(covariance.begin(), covariance.end(), c.begin(), [size](float value) { return value / size; });
  const auto [xx, xy, xz, yy, yz, zz] = c;
  const double in_xy = xx * yy - xy * xy, in_xz = xx * zz - xz * xz, in_yz = yy * zz - yz * yz;
  const double determinant = xx * in_yz - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  constexpr double rounding = 8 * std::numeric_limits<float>::epsilon();
  return std::min({xx, yy, zz, in_xy, in_xz, in_yz, determinant}) >= -rounding;
}

} // namespace

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

void requireCovariances(const PointCovariances& covariances, std::size_t points, const char* whose)
{
  if (covariances.size() < points)
    throw InvalidArgument(std::string("the covariances of the ") + whose + " are " +
                          std::to_string(covariances.size()) + ", its points " + std::to_string(points));
  for (std::size_t i = 0; i < covariances.size(); ++i) {
    const char* const fault = !isFinite(covariances[i])         ? "is not finite"
                              : !isSemidefinite(covariances[i]) ? "has a negative eigenvalue"
                                                                : nullptr;
    if (fault)
      throw InvalidArgument("covariance " + std::to_string(i) + " of the " + whose + " " + fault);
  }
}

} // namespace pcl_gpu_icp
