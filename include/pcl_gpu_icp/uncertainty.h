#pragma once

#include <pcl_gpu_icp/export.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <array>
#include <vector>

namespace pcl_gpu_icp {

/// How well its pairs hold an answer, to first order: of a small motion x -> x + turn x (x - centre) + shift that
/// follows it, in the target's frame. Its six unknowns are the turns about x, y and z, in radians, and then the shifts
/// along them, in the clouds' unit. It knows the noise of the pairs and not whether they are the right ones: an answer
/// in a wrong place is as sure of itself as one in the right place. Point-to-point counts points as held
/// along their surface too, where other points of it would do as well; planes and GICP do not. Beyond 16,384 pairs
/// some of it is from a sample of them.
struct Uncertainty {
  /// Of a turn about it, or of a shift along it.
  struct Axis {
    std::array<double, 3> direction{}; ///< of length 1
    double deviation = 0;              ///< standard deviation; infinite: the pairs do not determine it
  };

  std::array<double, 3> centre{};       ///< of the source's points, aligned
  std::array<double, 36> information{}; ///< row-major: the sum of J^T M J, with M the pairs' weights
  std::array<double, 36> covariance{};  ///< row-major: sigma^2 times the inverse over what is determined
  std::array<double, 36> determined{};  ///< row-major: takes a motion to what of it the pairs determine
  double sigma = 0;                     ///< standard deviation of a residual
  int free_motions = 0;                 ///< of those allowed, how many the pairs do not determine
  /// Of the motions allowed, those that vary apart from one another; the best determined first.
  std::vector<Axis> turns, shifts;
};

/// The pose nearest to the guess among those that the pairs cannot tell from `pose`: of the way from the guess to it
/// what is determined.
PCL_GPU_ICP_API RigidTransform determinedPart(const RigidTransform& guess,
                                              const RigidTransform& pose,
                                              const Uncertainty& uncertainty);

} // namespace pcl_gpu_icp
