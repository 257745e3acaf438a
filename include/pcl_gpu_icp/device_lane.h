#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/device_share.h>
#include <pcl_gpu_icp/matcher.h>
#include <pcl_gpu_icp/normal_estimator.h>
#include <pcl_gpu_icp/rigid_estimator.h>
#include <pcl_gpu_icp/search/shared_cache.h>

#include <cstdint>
#include <memory>
#include <tuple>
#include <utility>

namespace pcl_gpu_icp {

/// Targets on a device, by the fingerprint of their points: one tree, and its normals once, for all lanes that align
/// onto it.
struct TargetCache {
  /// Points, from how many neighbours, to which precision.
  using NormalsOf = std::tuple<std::uint64_t, unsigned, Precision>;

  search::SharedCache<search::NearestIndex> indices; ///< on the host
  search::SharedCache<MatchTarget> trees;            ///< that the device searches
  search::SharedCache<MatchTarget> leaves;           ///< the points of an index
  search::SharedCache<NormalEstimator::Normals, NormalsOf> normals;
};

/// A place on a device where pairs are aligned one after another, beside other lanes: what an aligner is lent, and what
/// it leaves on the device for the next one.
struct DeviceLane {
  DeviceLane(const Device& on, std::shared_ptr<DeviceShare> shared, std::shared_ptr<TargetCache> cache)
  : device(on)
  , share(std::move(shared))
  , targets(std::move(cache))
  {
  }

  Device device;
  std::shared_ptr<DeviceShare> share;   ///< null: nobody else uses the device
  std::shared_ptr<TargetCache> targets; ///< null: none are shared
  unsigned threads = 1;                 ///< host threads for an aligner that asks for no number

  std::unique_ptr<Matcher> matcher;
  std::uint64_t matcher_target = 0;  ///< fingerprint of the target that it holds; 0: none
  std::uint64_t matcher_normals = 0; ///< and of its normals or covariances
  /// Where they were estimated; the source's for GICP. The next pair may be of these clouds again.
  std::shared_ptr<const NormalEstimator::Normals> target_normals, source_normals;
  CorrespondenceSearch matcher_search{};
  std::unique_ptr<RigidEstimator> estimator;
};

} // namespace pcl_gpu_icp
