#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/device_share.h>
#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/result.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <memory>
#include <vector>

namespace pcl_gpu_icp {

namespace opencl {
struct Traits;
}

/// What the five stages make of a set of pairs.
struct Estimate {
  RigidTransform transform; ///< least-squares rigid transform from source to target points
  Degeneracy degeneracy = Degeneracy::None;
  int free_motions = 0;  ///< of the six, those that Degeneracy::Sliding leaves as they were
  std::size_t pairs = 0; ///< pairs that took part; those with a non-finite point do not
  StageValues stages;

  /// In the points' own coordinates.
  std::array<double, 3> sourceCentroid() const
  {
    std::array<double, 3> centroid{};
    for (int i = 0; i < 3; ++i)
      centroid[i] = stages.source_pivot[i] + stages.source_centroid[i];
    return centroid;
  }
};

/// The five stages of rigid estimation on an OpenCL device (Kabsch 1976; Umeyama 1991): centroids, de-meaned clouds,
/// cross-covariance, SVD, rotation and translation. Knows nothing of PCL. One thread at a time; several estimators
/// share a device safely.
class PCL_GPU_ICP_API RigidEstimator {
public:
  /// \param precision Double is used where the device has it; precision() tells what runs
  RigidEstimator(const Device& device, Pipeline pipeline = Pipeline::Fused, Precision precision = Precision::Float);
  ~RigidEstimator();
  RigidEstimator(RigidEstimator&&) noexcept;
  RigidEstimator& operator=(RigidEstimator&&) noexcept;

  const DeviceInfo& device() const;
  Pipeline pipeline() const;
  Precision precision() const;

  /// Where the device is shared: whom to ask before each operation. null, the default: nobody.
  void setShare(std::shared_ptr<DeviceShare> share);

  /// Estimates from pairs (source[i], target[i]).
  /// \throws InvalidArgument when the counts differ, DeviceError
  Estimate estimate(const Points& source, const Points& target);

  /// Puts a cloud on the device, where it stays until replaced. Point i keeps its number.
  void setSource(const Points& source);
  void setTarget(const Points& target);

  /// Estimates the increment that takes the source at `pose` on to the target, from correspondences between the clouds
  /// on the device. The points of the correspondences must be finite.
  /// \throws InvalidArgument when a correspondence names a point that is not there
  Estimate estimate(const Correspondence* correspondences, std::size_t count, const RigidTransform& pose);

  /// The pivot that the source's coordinates are kept about on the device: where a rounded transform must be exact.
  const std::array<double, 3>& sourcePivot() const;

  /// De-meaned points of the last estimate: source x, y, z and target x, y, z, six rows of `pairs` values.
  /// \throws InvalidArgument for Pipeline::Fused, which never forms them
  std::vector<double> demeaned() const;

  /// Memory that it holds on the device.
  std::size_t deviceBytes() const;

  /// Time per stage and transfer since the last call.
  StageTimes takeTimes();

private:
  friend RigidEstimator makeEstimator(const Device&, const opencl::Traits&, Pipeline, Precision);
  struct Implementation;
  explicit RigidEstimator(std::unique_ptr<Implementation> implementation);
  /// Builds every kernel and runs it once, so that a kernel that does not compile shows here and no estimate waits.
  void warmUp();
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_gpu_icp
