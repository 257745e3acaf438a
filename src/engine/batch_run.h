#pragma once

#include "scheduler/executor.h"

#include <pcl_gpu_icp/batch_lanes.h>

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_gpu_icp {

/// The pairs of a batch on their way through the lanes: threads that each take the next pair when they have finished
/// one. Pairs are numbered from 0.
class BatchRun {
public:
  using Finished = std::function<void(std::size_t pair, const BatchResult&)>;

  struct Pair {
    std::size_t points;
    BatchPair align;
    bool cancelled = false;
  };

  /// \param first number of the first pair in what is recorded
  BatchRun(std::vector<Pair> pairs, const BatchSettings& settings, std::size_t first, Finished finished);

  /// \return one result for each pair
  std::vector<BatchResult> run(const std::vector<Device>& devices);

  /// From any thread.
  void cancel();
  void cancel(std::size_t pair);

private:
  /// What the lanes of a device have in common.
  struct Shared {
    Device device;
    scheduler::Executor executor;
    std::shared_ptr<TargetCache> targets = std::make_shared<TargetCache>();

    Shared(const Device& on, scheduler::Plan plan, std::size_t number, const BatchRun& run)
    : device(on)
    , executor(std::move(plan), number, run.settings_.schedule, run.epoch_)
    {
    }
  };

  void runLane(Shared& shared, std::size_t number);
  std::optional<scheduler::Plan::Ticket> admitNext();
  BatchResult align(std::size_t pair, DeviceLane& lane, scheduler::LaneShare& share);
  void settle(std::size_t pair, BatchResult result);
  void cancelLocked(std::size_t pair);

  const BatchSettings settings_;
  const std::size_t first_;
  const Finished finished_;
  const scheduler::Executor::Clock::time_point epoch_ = scheduler::Executor::Clock::now();

  std::mutex callback_; ///< one call of finished_ at a time; locked before the other
  std::mutex mutex_;    ///< of everything below
  std::condition_variable room_;
  std::vector<Pair> pairs_;
  scheduler::Plan admission_;                  ///< of pairs, whose requests are their points; ticket t is pair t - 1
  std::vector<scheduler::LaneShare*> lane_of_; ///< of the pairs in flight; null of the others
  std::vector<BatchResult> results_;
  std::string loss_;           ///< why a device was given up
  std::exception_ptr failure_; ///< what finished_ threw
};

} // namespace pcl_gpu_icp
