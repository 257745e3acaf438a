#pragma once

#include "kernels/layout.h"

#include <pcl_gpu_icp/rigid_estimator.h>

#include <array>

namespace pcl_gpu_icp {

/// The least-squares problem of linearised point-to-plane estimation (Low 2004) over matched pairs.
struct PlaneProblem {
  std::array<double, PLANE_SUMS> sums{}; ///< see kernels/layout.h
  std::array<double, 3> centre{};        ///< the point that the small rotation turns about
  double length = 1;                     ///< a lever that makes rotations comparable with translations
  double row_noise = 0;                  ///< what the rows' own rounding is, relative to a unit normal
  double sum_noise = 0;                  ///< what the sums' rounding is, relative to the largest of them
};

/// The motion that solves it, as stages.R about stages.source_centroid (the centre) and on to stages.target_centroid;
/// of several the smallest. Motions whose share in the sums is below the noise are free: they are left out and counted.
/// R is made from the three small angles as pcl::registration::TransformationEstimationPointToPlaneLLS makes it.
Estimate solved(const PlaneProblem& problem);

} // namespace pcl_gpu_icp
