#pragma once

#include "kernels/layout.h"
#include "symmetric_eigen.h"

#include <pcl_gpu_icp/motions.h>
#include <pcl_gpu_icp/rigid_estimator.h>

#include <array>

namespace pcl_gpu_icp {

/// The normal equations of a metric over matched pairs, for a small turn about a centre and a shift.
struct System {
  std::array<double, SYSTEM_SUMS> sums{}; ///< see kernels/layout.h
  std::array<double, 3> centre{};         ///< the point that the small rotation turns about
  double length = 1;                      ///< a lever that makes rotations comparable with translations
  double row_noise = 0;                   ///< what the rows' own rounding is, relative to a unit normal
  double sum_noise = 0;                   ///< what the sums' rounding is, relative to the largest of them
  Motions motions = Motions::Rigid;       ///< that the solution may be
  bool turns_by_halves = false;           ///< before the shift and after it (Rusinkiewicz 2019)

  /// Of the pairs' information along x, y and z.
  double weight() const { return sums[15] + sums[18] + sums[20]; }
  double cost() const { return sums[27]; }
  /// The trace of the pairs' information without a loss.
  double unweighedTrace() const { return sums[28]; }
};

/// The matrix of its six unknowns.
SquareMatrix<6> matrixOf(const System& system);
void setMatrix(System& system, const SquareMatrix<6>& matrix);

/// A system's matrix by motions that do not depend on each other.
struct Spectrum {
  std::array<bool, 6> allowed{}; ///< of the unknowns, and of the motions of the same number
  SquareMatrix<6> motions{};     ///< columns: the unknowns of each; of what is not allowed zero
  SquareMatrix<6> shares{};      ///< rows: how much of each motion the unknowns are
  std::array<double, 6> values{};
  double noise = 0; ///< what of a value is nothing

  bool isDetermined(int k) const { return allowed[k] && values[k] > noise; }
  bool isFree(int k) const { return allowed[k] && !isDetermined(k); }
};

/// With rotations in units of what they move the lever's end by, motions are eigenvectors of length 1.
Spectrum spectrumOf(const System& system);

/// The motion that solves it, as stages.R about stages.source_centroid (the centre) and on to stages.target_centroid;
/// of several the smallest. Motions that are not allowed are none; those whose share in the sums is below the noise are
/// free: they are left out and counted. R is made from the three small angles as
/// pcl::registration::TransformationEstimationPointToPlaneLLS makes it. \param share of the step that is taken
Estimate solved(const System& system, double share = 1);

} // namespace pcl_gpu_icp
