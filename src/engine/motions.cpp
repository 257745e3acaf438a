#include <pcl_gpu_icp/motions.h>

#include <cmath>

namespace pcl_gpu_icp {

const char* toString(Motions motions)
{
  switch (motions) {
  case Motions::Rigid:
    return "rigid";
  case Motions::Planar:
    return "planar";
  case Motions::Yaw:
    return "yaw";
  case Motions::Translation:
    return "translation";
  }
  return "unknown";
}

std::array<bool, 6> unknownsOf(Motions motions)
{
  const bool tilts = motions == Motions::Rigid, turns = motions != Motions::Translation;
  return {tilts, tilts, turns, true, true, motions != Motions::Planar};
}

RigidTransform restricted(const RigidTransform& motion, Motions motions, const std::array<double, 3>& anchor)
{
  if (motions == Motions::Rigid)
    return motion;
  const auto unknowns = unknownsOf(motions);
  RigidTransform result;
  if (unknowns[2]) {
    const auto& r = motion.rotation;
    const double angle = std::atan2(r[3] - r[1], r[0] + r[4]);
    const double cosine = std::cos(angle), sine = std::sin(angle);
    result.rotation = {cosine, -sine, 0, sine, cosine, 0, 0, 0, 1};
  }
  const auto image = motion(anchor[0], anchor[1], anchor[2]);
  const auto turned = result(anchor[0], anchor[1], anchor[2]);
  for (int axis = 0; axis < 3; ++axis)
    result.translation[axis] = unknowns[3 + axis] ? image[axis] - turned[axis] : 0;
  return result;
}

} // namespace pcl_gpu_icp
