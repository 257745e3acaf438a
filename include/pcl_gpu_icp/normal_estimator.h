#pragma once

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/device_share.h>
#include <pcl_gpu_icp/points.h>
#include <pcl_gpu_icp/result.h>

#include <array>
#include <memory>
#include <vector>

namespace pcl_gpu_icp {

namespace opencl {
struct Traits;
}

/// Surface normals of a cloud, on an OpenCL device: for each point the direction in which its nearest points, itself
/// among them, vary least (Hoppe et al. 1992). One thread at a time.
class PCL_GPU_ICP_API NormalEstimator {
public:
  using Normals = std::vector<std::array<float, 3>>;
  static constexpr unsigned default_neighbours = 20;
  static constexpr unsigned most_neighbours = 32;

  /// \param precision of the covariances: Double is used where the device has it
  NormalEstimator(const Device& device, Precision precision);
  ~NormalEstimator();
  NormalEstimator(NormalEstimator&&) noexcept;
  NormalEstimator& operator=(NormalEstimator&&) noexcept;

  /// Asks `share` before each operation, from now on; null: nobody else uses the device.
  void setShare(std::shared_ptr<DeviceShare> share);

  const DeviceInfo& device() const;
  Precision precision() const;

  /// A unit vector of either sign for each point, in their order; NaN for points that are not finite, and where the
  /// nearest points lie on a line or at one place. Points that coincide count as one neighbour.
  /// \param neighbours 3 to most_neighbours
  /// \throws InvalidArgument for another number of neighbours, DeviceError
  Normals estimate(const Points& points, unsigned neighbours = default_neighbours);

  /// Time per stage and transfer since the last call.
  StageTimes takeTimes();

private:
  friend NormalEstimator makeNormalEstimator(const Device&, const opencl::Traits&, Precision);
  struct Implementation;
  explicit NormalEstimator(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

/// Normals that a caller gave.
/// \throws InvalidArgument where no point has any: all are zero, as where nobody computed them, or not finite
PCL_GPU_ICP_API void requireNormals(const Points& normals, const char* whose);

} // namespace pcl_gpu_icp
