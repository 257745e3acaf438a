#pragma once

#include "made_pairs.h"

#include <pcl_gpu_icp/icp.h>

#include <stdexcept>

namespace made_pairs {

/// What an alignment came to, and whether what judge() says of it is true.
struct JudgedPair {
  pcl_gpu_icp::AlignmentResult result; ///< has a quality
  pcl_gpu_icp::Judgement judgement;
  double off;    ///< spacings, root mean square over the source
  bool is_right; ///< never of unrelated clouds
};

inline JudgedPair judged(const Pair& pair, pcl_gpu_icp::Metric metric)
{
  constexpr int iterations = 60;
  pcl_gpu_icp::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ, double> icp;
  icp.setCorrespondenceSearch(pcl_gpu_icp::CorrespondenceSearch::DeviceKdTree);
  icp.setMaximumIterations(iterations);
  icp.setMetric(metric);
  icp.setInputSource(pair.source);
  icp.setInputTarget(pair.target);
  icp.alignWithoutOutput(pair.guess.matrix());
  const pcl_gpu_icp::AlignmentResult& result = icp.getResult();
  if (!result.quality)
    throw std::runtime_error(pair.kind + " " + pair.clouds + ": " + result.message);
  const double off = errorOf(pair, Eigen::Affine3d(icp.getFinalTransformation())) / result.quality->spacing;
  return {result, judge(*result.quality), off, pair.isRelated() && off <= right_spacings};
}

} // namespace made_pairs
