#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/rigid_estimator.h>

#include <memory>

namespace pcl_gpu_icp {

/// Linearised point-to-plane estimation (Chen and Medioni 1992; Low 2004) from listed pairs, on an OpenCL device. Knows
/// nothing of PCL. One thread at a time; several estimators share a device safely.
class PCL_GPU_ICP_API PlaneEstimator {
public:
  /// \param precision Double is used where the device has it; precision() tells what runs
  PlaneEstimator(const Device& device, Precision precision);
  ~PlaneEstimator();
  PlaneEstimator(PlaneEstimator&&) noexcept;
  PlaneEstimator& operator=(PlaneEstimator&&) noexcept;

  const DeviceInfo& device() const;
  Precision precision() const;

  /// Estimates from source[i], target[i] and the normal there, normals[i], of either sign. Pairs with a value that is
  /// not finite do not take part. The small rotation turns about the source's centroid.
  /// \throws InvalidArgument when the counts differ, DeviceError
  Estimate estimate(const Points& source, const Points& target, const Points& normals);

  /// Time per stage and transfer since the last call.
  StageTimes takeTimes();

private:
  friend PlaneEstimator makePlaneEstimator(const Device&, const opencl::Traits&, Precision);
  struct Implementation;
  explicit PlaneEstimator(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_gpu_icp
