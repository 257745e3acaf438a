#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/device_share.h>
#include <pcl_gpu_icp/matcher.h>
#include <pcl_gpu_icp/rigid_estimator.h>

#include <cstdint>
#include <memory>
#include <utility>

namespace pcl_gpu_icp {

/// A place on a device where pairs are aligned one after another, beside other lanes: what an aligner is lent, and what
/// it leaves on the device for the next one.
struct DeviceLane {
  explicit DeviceLane(const Device& on, std::shared_ptr<DeviceShare> shared = nullptr)
  : device(on)
  , share(std::move(shared))
  {
  }

  Device device;
  std::shared_ptr<DeviceShare> share; ///< null: nobody else uses the device
  unsigned threads = 1;               ///< host threads for an aligner that asks for no number

  std::unique_ptr<Matcher> matcher;
  std::uint64_t matcher_target = 0; ///< fingerprint of the target that it holds; 0: none
  CorrespondenceSearch matcher_search{};
  std::unique_ptr<RigidEstimator> estimator;
};

} // namespace pcl_gpu_icp
