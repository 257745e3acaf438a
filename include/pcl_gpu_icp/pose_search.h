#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/device_share.h>
#include <pcl_gpu_icp/motions.h>
#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/quality.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace pcl_gpu_icp {

/// A pose of the source on the target, and how well it fits.
struct PoseCandidate {
  RigidTransform transform; ///< source to target
  /// From 0 to 1: of the source's points, and of the target's that the source would show, how near they are to the
  /// other cloud, each for itself (Geman-McClure) and the two multiplied.
  double score = 0;
  /// Matches of the clouds' features (Fast Point Feature Histograms, Rusu et al. 2009) that it puts on each other.
  std::size_t support = 0;
  Quality quality; ///< of the pose on the clouds as they are
};

struct PoseSearchResult {
  std::vector<PoseCandidate> poses; ///< the best first, each far from those before it; empty: a cloud has too few
                                    ///< points, or nothing fits anywhere
  std::size_t starts = 0;           ///< poses that were tried

  /// A pose other than the best, of which nobody could tell from the clouds whether it is the right one: it fits nearly
  /// as well, as where a cloud is symmetric, or plainly in part, as where both are a half of a room and its walls are
  /// alike. Of several the one with the greatest fitOf(); null: there is none. It is one of `poses`.
  PCL_GPU_ICP_API const PoseCandidate* rival() const&;

  bool isAmbiguous() const { return rival() != nullptr; }
};

/// Where ICP starts when nothing is known of the pose. First the poses on which matches of features agree (Fast Point
/// Feature Histograms, Rusu et al. 2009; SC2-PCR, Chen et al., CVPR 2022): where one of them has most of the matches
/// that is all. Else rotations spread evenly over all there are (Alexa, Super-Fibonacci Spirals, CVPR 2022), or over
/// the headings, each with the centroids and with the origins of the clouds on each other. All are brought nearer by a
/// few robust iterations on thinned clouds, many at once through the scheduler of a batch; the best go on, on finer
/// clouds, and are judged in both directions. The same answer every time. A pose is found where the clouds have half of
/// their surfaces in common, or one is a part of the other: it is a start for ICP, within about a voxel of the finer
/// thinning.
class PCL_GPU_ICP_API PoseSearch {
public:
  explicit PoseSearch(const Device& device);

  /// How the source may move from the guess: Motions::Rigid by default. With Yaw or Planar only headings are tried.
  void setMotions(Motions motions) { motions_ = motions; }

  /// Called after each of `all` groups of starts, which become fewer where no more are needed.
  void setProgress(std::function<void(std::size_t done, std::size_t all)> progress) { progress_ = std::move(progress); }

  /// Starts in flight at a time; 0, the default: as BatchSettings::lanes.
  void setLanes(unsigned lanes) { lanes_ = lanes; }

  /// Where the device is shared: whom to ask before each operation; starts then run one after another. null, the
  /// default: nobody.
  void setShare(std::shared_ptr<DeviceShare> share) { share_ = std::move(share); }

  /// \param guess what it leads to is among the poses unless it fits nowhere; with fewer motions what they leave as it
  /// is comes from it
  /// \throws DeviceError
  PoseSearchResult search(const Points& source, const Points& target, const RigidTransform& guess = {}) const;

private:
  Device device_;
  Motions motions_ = Motions::Rigid;
  unsigned lanes_ = 0;
  std::shared_ptr<DeviceShare> share_;
  std::function<void(std::size_t, std::size_t)> progress_;
};

} // namespace pcl_gpu_icp
