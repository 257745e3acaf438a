#pragma once

#include <pcl_gpu_icp/device_lane.h>
#include <pcl_gpu_icp/result.h>
#include <pcl_gpu_icp/rigid_transform.h>
#include <pcl_gpu_icp/schedule.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace pcl_gpu_icp {

/// What became of one cloud pair of a batch.
struct BatchResult {
  AlignmentResult alignment;           ///< as getResult() of a single alignment
  RigidTransform transform;            ///< source to target: the final transformation
  std::optional<double> fitness_score; ///< where it was asked for and there is one
  std::size_t device = 0;              ///< number of the device, as given to BatchAligner
  double begin_ms = 0;                 ///< since run() began
  double end_ms = 0;
};

/// Aligns one pair. What it throws is that pair's result.
using BatchPair = std::function<BatchResult(DeviceLane&)>;

struct BatchSettings {
  unsigned lanes = 0;               ///< pairs in flight on each device; 0: twice the host's cores, at most 8
  std::size_t points_in_flight = 0; ///< of the pairs in flight together; a larger pair runs alone. 0: no bound
  std::size_t capacity = 0;         ///< work-items that a device holds at once; 0: as it reports
  Policy policy = Policy::SmallestFirst;
  bool keep_results = true; ///< false: run() returns none, and the memory for them is that of the pairs in flight
  std::shared_ptr<Schedule> schedule; ///< where to record what runs; null: nowhere
};

/// Runs pairs on the lanes of devices.
class PCL_GPU_ICP_API BatchLanes {
public:
  BatchLanes();
  ~BatchLanes();
  BatchLanes(const BatchLanes&) = delete;
  BatchLanes& operator=(const BatchLanes&) = delete;

  /// \param points of both clouds, as far as is known: what the pair is ordered by, and counted as in flight
  /// \return its number, from 0
  std::size_t add(std::size_t points, BatchPair pair);

  std::size_t size() const;

  /// Runs those added since the last run.
  /// \param finished called after each, by one thread at a time; what it throws cancels the others and is rethrown
  /// \return one result for each pair, in the order added; none with keep_results off
  std::vector<BatchResult> run(const std::vector<Device>& devices,
                               const BatchSettings& settings,
                               const std::function<void(std::size_t pair, const BatchResult&)>& finished);

  /// Ends the pairs that have not finished, those in flight at their next operation: their reason is
  /// Reason::Cancelled. From any thread, also before run().
  void cancel();
  void cancel(std::size_t pair);

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_gpu_icp
