#pragma once

#include "cli/cloud_pair.h"
#include "cli/options.h"

#include "report/degrees.h"

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/icp.h>

#include <pcl/registration/correspondence_rejection_trimmed.h>

#include <cmath>

namespace pcl_gpu_icp::cli {

/// Applies the settings that stock PCL and the plugin share.
template <typename Icp>
void applySettings(Icp& icp, const AlignmentOptions& options)
{
  icp.setMaximumIterations(options.iterations);
  icp.setUseReciprocalCorrespondences(options.reciprocal);
  if (options.max_distance)
    icp.setMaxCorrespondenceDistance(*options.max_distance);
  if (options.translation_epsilon)
    icp.setTransformationEpsilon(*options.translation_epsilon * *options.translation_epsilon);
  if (options.rotation_epsilon)
    icp.setTransformationRotationEpsilon(std::cos(*options.rotation_epsilon * report::radians_per_degree));
  if (options.fitness_epsilon)
    icp.setEuclideanFitnessEpsilon(*options.fitness_epsilon);
  if (options.trim) {
    const auto trimmed = pcl::make_shared<pcl::registration::CorrespondenceRejectorTrimmed>();
    trimmed->setOverlapRatio(static_cast<float>(*options.trim));
    icp.addCorrespondenceRejector(trimmed);
  }
}

/// Applies the settings that the plugin alone has.
template <typename PointT, typename Scalar>
void applyPluginSettings(IterativeClosestPoint<PointT, PointT, Scalar>& icp,
                         const AlignmentOptions& options,
                         const Device& device)
{
  icp.setDevice(device);
  icp.setCorrespondenceSearch(options.search);
  icp.setPipeline(options.pipeline);
  icp.setAndersonAcceleration(options.anderson);
  icp.setNumberOfThreads(options.threads);
  icp.setMetric(options.metric);
  icp.setLoss(options.loss);
  icp.setMotions(options.motions);
  icp.setKeepUndetermined(options.undetermined == Undetermined::Keep);
}

/// An aligner's clouds and all its settings.
template <typename Icp>
void setUp(Icp& icp, const CloudPair& pair, const AlignmentOptions& options, const Device& device)
{
  applySettings(icp, options);
  applyPluginSettings(icp, options, device);
  icp.setInputSource(pair.source->points);
  icp.setInputTarget(pair.target->points);
}

/// Throws what ended an alignment.
inline void requireNoError(const AlignmentResult& result)
{
  if (result.reason == Reason::Error)
    std::rethrow_exception(result.error);
}

} // namespace pcl_gpu_icp::cli
