#include <pcl_gpu_icp/rigid_transform.h>

#include <cmath>
#include <cstddef>

namespace pcl_gpu_icp {

namespace {

std::array<double, 3> rotated(const std::array<double, 9>& r, const std::array<double, 3>& x)
{
  return {r[0] * x[0] + r[1] * x[1] + r[2] * x[2],
          r[3] * x[0] + r[4] * x[1] + r[5] * x[2],
          r[6] * x[0] + r[7] * x[1] + r[8] * x[2]};
}

/// Signed.
double minorOf(const std::array<double, 9>& r, int i, int j)
{
  const int a = 3 * ((i + 1) % 3), b = 3 * ((i + 2) % 3), c = (j + 1) % 3, d = (j + 2) % 3;
  return r[a + c] * r[b + d] - r[a + d] * r[b + c];
}

double determinantOf(const std::array<double, 9>& r)
{
  return r[0] * minorOf(r, 0, 0) + r[1] * minorOf(r, 0, 1) + r[2] * minorOf(r, 0, 2);
}

} // namespace

RigidTransform compose(const RigidTransform& second, const RigidTransform& first)
{
  RigidTransform result;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      result.rotation[3 * i + j] = 0;
      for (int k = 0; k < 3; ++k)
        result.rotation[3 * i + j] += second.rotation[3 * i + k] * first.rotation[3 * k + j];
    }
  const auto& t = first.translation;
  result.translation = second(t[0], t[1], t[2]);
  return result;
}

RigidTransform inverse(const RigidTransform& transform)
{
  const auto& r = transform.rotation;
  const double determinant = determinantOf(r);
  RigidTransform result;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      result.rotation[3 * i + j] = minorOf(r, j, i) / determinant;
  const auto moved = rotated(result.rotation, transform.translation);
  for (int i = 0; i < 3; ++i)
    result.translation[i] = -moved[i];
  return result;
}

bool isRigid(const RigidTransform& transform)
{
  const auto& r = transform.rotation;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const double product = r[3 * i] * r[3 * j] + r[3 * i + 1] * r[3 * j + 1] + r[3 * i + 2] * r[3 * j + 2];
      if (!(std::abs(product - (i == j ? 1 : 0)) <= rigid_tolerance))
        return false;
    }
  const auto& t = transform.translation;
  return determinantOf(r) > 0 && std::isfinite(t[0]) && std::isfinite(t[1]) && std::isfinite(t[2]);
}

RigidTransform nearestRigid(const RigidTransform& transform, const std::array<double, 3>& anchor)
{
  // Newton's iteration for the polar factor (Higham 1986) squares the error: from rigid_tolerance in three steps.
  constexpr int steps = 4;
  RigidTransform result = transform;
  for (int step = 0; step < steps; ++step) {
    const auto r = result.rotation;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        double correction = 0;
        for (int k = 0; k < 3; ++k)
          for (int l = 0; l < 3; ++l)
            correction += r[3 * i + k] * r[3 * l + k] * r[3 * l + j];
        result.rotation[3 * i + j] += 0.5 * (r[3 * i + j] - correction);
      }
  }
  const auto image = transform(anchor[0], anchor[1], anchor[2]);
  const auto turned = rotated(result.rotation, anchor);
  for (int i = 0; i < 3; ++i)
    result.translation[i] = image[i] - turned[i];
  return result;
}

RigidTransform
recentred(const RigidTransform& transform, const std::array<double, 3>& from, const std::array<double, 3>& to)
{
  RigidTransform result = transform;
  const auto image = transform(from[0], from[1], from[2]);
  for (int i = 0; i < 3; ++i)
    result.translation[i] = image[i] - to[i];
  return result;
}

} // namespace pcl_gpu_icp
