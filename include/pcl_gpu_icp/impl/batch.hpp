#pragma once

#include <pcl_gpu_icp/batch.h>
#include <pcl_gpu_icp/impl/matrix.hpp>

namespace pcl_gpu_icp {

template <typename PointSource, typename PointTarget, typename Scalar>
std::size_t BatchAligner::add(const typename pcl::PointCloud<PointSource>::ConstPtr& source,
                              const typename pcl::PointCloud<PointTarget>::ConstPtr& target,
                              Configure<PointSource, PointTarget, Scalar> configure,
                              const Guess<Scalar>& guess)
{
  if (!source || !target)
    throw InvalidArgument(std::string("BatchAligner::add: no ") + (source ? "target" : "source") + " cloud");
  const Eigen::Matrix<Scalar, 4, 4, Eigen::DontAlign> from = guess; // else the closure would have to be aligned for it
  return add(source->size() + target->size(), [=](DeviceLane& lane) {
    IterativeClosestPoint<PointSource, PointTarget, Scalar> icp;
    if (configure)
      configure(icp);
    icp.setInputSource(source);
    icp.setInputTarget(target);
    return align(lane, icp, from);
  });
}

template <typename PclIcp>
BatchResult BatchAligner::align(DeviceLane& lane,
                                DeviceIcp<PclIcp>& icp,
                                const typename PclIcp::Matrix4& guess,
                                bool with_fitness_score)
{
  icp.enter(lane);
  icp.alignWithoutOutput(guess);
  BatchResult result;
  result.alignment = icp.getResult();
  result.transform = detail::toRigidTransform<typename PclIcp::Matrix4::Scalar>(icp.getFinalTransformation());
  if (with_fitness_score && result.alignment.reason != Reason::Error && result.alignment.reason != Reason::Cancelled) {
    const double fitness_score = icp.getFitnessScore();
    if (fitness_score < std::numeric_limits<double>::max())
      result.fitness_score = fitness_score;
  }
  icp.leave(lane);
  return result;
}

inline std::vector<BatchResult>
BatchAligner::run(const std::function<void(std::size_t pair, const BatchResult&)>& finished)
{
  if (devices_.empty())
    devices_.push_back(Device::select());
  return lanes_.run(devices_, settings_, finished);
}

} // namespace pcl_gpu_icp
