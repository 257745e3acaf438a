#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/device_share.h>
#include <pcl_gpu_icp/motions.h>
#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/quality.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <cstddef>
#include <memory>
#include <utility>

namespace pcl_gpu_icp {

struct OverlapSearchResult {
  RigidTransform transform; ///< source to target; the guess where a cloud has too few points
  Quality quality;          ///< there: after.source is the share of the source that has a partner
  std::size_t ways = 0;     ///< that were tried; 0: a cloud has too few points
};

/// Brings the part that two clouds have in common onto each other, where nobody knows how much that is: coarse to fine,
/// by voxels of half the size each time, to planes, with a loss (Geman-McClure) by which what has no partner does not
/// pull. Several ways differ in the first size and the width of the loss; the first that is judged good is taken, or of
/// all the best. The same answer every time. The guess may be some 30 degrees and a tenth of the extent off. The answer
/// is a start for ICP with a loss of about quality.spacing: without one the parts without a partner would pull it away
/// again.
class PCL_GPU_ICP_API OverlapSearch {
public:
  explicit OverlapSearch(const Device& device);

  /// How the source may move from the guess: Motions::Rigid by default.
  void setMotions(Motions motions) { motions_ = motions; }

  /// Where the device is shared: whom to ask before each operation. null, the default: nobody.
  void setShare(std::shared_ptr<DeviceShare> share) { share_ = std::move(share); }

  /// \throws DeviceError
  OverlapSearchResult search(const Points& source, const Points& target, const RigidTransform& guess = {}) const;

private:
  Device device_;
  Motions motions_ = Motions::Rigid;
  std::shared_ptr<DeviceShare> share_;
};

} // namespace pcl_gpu_icp
