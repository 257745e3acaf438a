#include "pose_starts.h"

#include "geometry/quaternion.h"

#include <cmath>
#include <cstddef>

namespace pcl_gpu_icp {

namespace {

constexpr double pi = 3.14159265358979323846;

/// Evenly over all rotations (Alexa 2022).
std::array<double, 9> superFibonacci(std::size_t i, std::size_t n)
{
  constexpr double phi = 1.41421356237309504880, psi = 1.53375116875520428812;
  const double s = static_cast<double>(i) + 0.5, t = s / static_cast<double>(n), d = 2 * pi * s;
  const double r = std::sqrt(t), R = std::sqrt(1 - t), alpha = d / phi, beta = d / psi;
  const double x = r * std::sin(alpha), y = r * std::cos(alpha), z = R * std::sin(beta), w = R * std::cos(beta);
  return rotationOf({w, x, y, z});
}

} // namespace

std::vector<std::array<double, 9>> turnsOf(Motions motions)
{
  constexpr std::size_t rotations = 576, headings = 36;
  std::vector<std::array<double, 9>> turns{RigidTransform().rotation};
  if (motions == Motions::Rigid)
    for (std::size_t i = 0; i < rotations; ++i)
      turns.push_back(superFibonacci(i, rotations));
  else if (motions != Motions::Translation)
    for (std::size_t i = 1; i < headings; ++i) {
      const double angle = 2 * pi * static_cast<double>(i) / headings;
      turns.push_back({std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1});
    }
  return turns;
}

} // namespace pcl_gpu_icp
