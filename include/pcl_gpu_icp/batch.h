#pragma once

#include <pcl_gpu_icp/batch_lanes.h>
#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/matrix.h>

#include <pcl/point_cloud.h>

#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

namespace pcl_gpu_icp {

/// Aligns many cloud pairs on one device, or on several. A few pairs are in flight at once, so that one uses the
/// device while another reads its files, builds its tree or decides whether to stop. Before each operation a pair asks
/// for the work-items it needs; what falls idle goes to the smallest request first. Every transform is, to the bit,
/// the one that the pair gets alone.
///
///     pcl_gpu_icp::BatchAligner batch;
///     for (const auto& scan : scans)
///       batch.add<pcl::PointXYZ, pcl::PointXYZ>(scan, map, [](auto& icp) { icp.setMaximumIterations(30); });
///     for (const pcl_gpu_icp::BatchResult& result : batch.run())
///       use(pcl_gpu_icp::toMatrix(result.transform)); // an Eigen::Matrix4f
///
/// Targets of the same coordinates share one tree on a device.
class BatchAligner {
public:
  // common_type_t, so that a lambda is converted and not taken to deduce from.
  template <typename PointSource, typename PointTarget, typename Scalar = float>
  using Configure = std::common_type_t<std::function<void(IterativeClosestPoint<PointSource, PointTarget, Scalar>&)>>;
  template <typename Scalar>
  using Guess = std::common_type_t<Eigen::Matrix<Scalar, 4, 4>>;

  /// \param devices pairs go to whichever is free; empty: Device::select()
  explicit BatchAligner(std::vector<Device> devices = {})
  : devices_(std::move(devices))
  {
  }

  /// See BatchSettings.
  void setSettings(BatchSettings settings) { settings_ = std::move(settings); }
  const BatchSettings& getSettings() const { return settings_; }

  /// Adds a pair.
  /// \param configure sets up the aligner that the pair gets, e.g. its criteria; as of a new one by default
  /// \return its number, from 0
  template <typename PointSource, typename PointTarget, typename Scalar = float>
  std::size_t add(const typename pcl::PointCloud<PointSource>::ConstPtr& source,
                  const typename pcl::PointCloud<PointTarget>::ConstPtr& target,
                  Configure<PointSource, PointTarget, Scalar> configure = {},
                  const Guess<Scalar>& guess = Eigen::Matrix<Scalar, 4, 4>::Identity());

  /// Adds a pair that gets its clouds when its turn comes, e.g. from files, and aligns them with align().
  /// \param points of both clouds, as far as is known: what the pair is ordered by, and counted as in flight
  std::size_t add(std::size_t points, BatchPair pair) { return lanes_.add(points, std::move(pair)); }

  /// For such a pair: runs an aligner of any of the ICP classes, which has its clouds and settings, on the lane.
  /// \param with_fitness_score asks for getFitnessScore() as well
  template <typename PclIcp>
  static BatchResult align(DeviceLane& lane,
                           DeviceIcp<PclIcp>& icp,
                           const typename PclIcp::Matrix4& guess = PclIcp::Matrix4::Identity(),
                           bool with_fitness_score = false);

  std::size_t size() const { return lanes_.size(); }

  /// Aligns what was added since the last run.
  /// \param finished called after each pair, by one thread at a time; what it throws cancels the others and is rethrown
  /// \return one result for each pair, in the order added: a pair that fails has Reason::Error and harms no other
  /// \throws DeviceError when there is no device
  std::vector<BatchResult> run(const std::function<void(std::size_t pair, const BatchResult&)>& finished = {});

  /// Ends the pairs that have not finished, those in flight at their next operation: their reason is
  /// Reason::Cancelled. From any thread.
  void cancel() { lanes_.cancel(); }
  void cancel(std::size_t pair) { lanes_.cancel(pair); }

private:
  std::vector<Device> devices_;
  BatchSettings settings_;
  BatchLanes lanes_;
};

} // namespace pcl_gpu_icp

#include <pcl_gpu_icp/impl/batch.hpp>
