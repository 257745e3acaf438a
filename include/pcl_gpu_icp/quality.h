#pragma once

#include <pcl_gpu_icp/export.h>
#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace pcl_gpu_icp {

/// Shares of points, from 0 to 1, that are within three spacings of the other cloud.
struct OverlapShares {
  double source = 0; ///< of the source's
  double target = 0; ///< of the target's that are in view: within the box around the source
};

/// Of the source's points within three spacings, those where both clouds are surfaces.
struct SurfaceFit {
  double share = 0;                                          ///< of the points within three spacings
  double alike = 0;                                          ///< share whose surfaces are within 25 degrees of parallel
  double distance = std::numeric_limits<double>::infinity(); ///< median, from a point to the target's surface;
                                                             ///< infinite: there is none
  /// How far a few robust steps of these points onto the target's surface would move them, root mean square: about
  /// as far as the pose is from the right one, where that is a few spacings.
  double pull = 0;
  /// What the surfaces say of the motion that they say least of: the smallest eigenvalue of their normals'
  /// information, to a unit of weight, turns measured at the root mean square radius. 0 for a plane or a sphere, 0.07
  /// in a room.
  double hold = 0;
};

/// How a pose puts a source on a target, measured at some hundred points of each. Distances but for the spacing itself
/// are in spacings. Of a cloud of many points 16,384 are looked at.
struct Quality {
  double spacing = 0; ///< of the target's points that are looked at, in the clouds' unit; 0: nothing was measured
  OverlapShares before, after;                                      ///< at the guess and at the pose
  double median_distance = std::numeric_limits<double>::infinity(); ///< to the target; infinite: more than three
  double concentration = 0; ///< of the source's points within three spacings, the share within one: by chance a third

  std::optional<SurfaceFit> surfaces; ///< none: the clouds are none, as where points lie scattered
};

/// Of any pose, wherever it came from. The same bits for any number of threads.
/// \param guess where an alignment started, and pose, where it ended: source to target
/// \param threads on the host; 0: all cores
PCL_GPU_ICP_API Quality qualityOf(const Points& source,
                                  const Points& target,
                                  const RigidTransform& guess,
                                  const RigidTransform& pose,
                                  unsigned threads = 0);

/// From 0 to 1, whatever the clouds have in common: how closely what is near lies, and how much is. Compares poses of
/// one pair.
PCL_GPU_ICP_API double fitOf(const Quality& quality);

/// Whether to believe a pose.
enum class Verdict {
  Good,
  Doubtful, ///< as where the clouds overlap in part, or slide along each other: right perhaps
  Wrong,
};

PCL_GPU_ICP_API const char* toString(Verdict verdict);

struct Judgement {
  Verdict verdict = Verdict::Wrong;
  std::vector<std::string> reasons; ///< for anything but Good, the weightiest first, with the numbers
};

/// By limits that were set on pairs of known answers: see BENCHMARK.md.
PCL_GPU_ICP_API Judgement judge(const Quality& quality);

} // namespace pcl_gpu_icp
