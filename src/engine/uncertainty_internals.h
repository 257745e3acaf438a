#pragma once

#include "system_solution.h"

#include <pcl_gpu_icp/uncertainty.h>

namespace pcl_gpu_icp {

/// \param spectrum says what is determined: of the system, or of that of the pairs that fit
/// \param sigma standard deviation of a residual
Uncertainty uncertaintyOf(const System& system, const Spectrum& spectrum, double sigma);

/// The motions by how much of what they do to the points the system sees: a value is 1 where it sees all of it.
/// \param points matrix of the same unknowns for point-to-point pairs; where it leaves motions free as spectrumOf()
/// \param noise what of a value is nothing
Spectrum spectrumAgainst(const SquareMatrix<6>& points, const System& system, double noise);

} // namespace pcl_gpu_icp
