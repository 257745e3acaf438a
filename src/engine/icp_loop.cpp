#include <pcl_gpu_icp/icp_loop.h>

namespace pcl_gpu_icp {

RigidTransform iterate(IcpSteps& steps, const RigidTransform& guess)
{
  RigidTransform pose = guess;
  while (steps.match(pose)) {
    const RigidTransform increment = steps.estimateIncrement(pose);
    pose = compose(increment, pose);
    if (steps.finished(increment, pose))
      break;
  }
  return pose;
}

} // namespace pcl_gpu_icp
