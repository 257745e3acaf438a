#pragma once

#include "plan.h"

#include <pcl_gpu_icp/device_share.h>
#include <pcl_gpu_icp/schedule.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>

namespace pcl_gpu_icp::scheduler {

/// Runs a plan on a device: threads wait here until the plan starts what they request. Thread-safe.
class Executor {
public:
  using Clock = std::chrono::steady_clock;

  /// \param schedule records what runs, from `epoch` on; null: nobody looks
  Executor(Plan plan, std::size_t device, std::shared_ptr<Schedule> schedule, Clock::time_point epoch);

  /// Waits until the plan starts it.
  /// \throws Cancelled once `cancelled` is set and wake() is called
  Plan::Ticket start(std::size_t request, const std::atomic<bool>& cancelled);
  void narrow(Plan::Ticket ticket, std::size_t kept);
  void end(Plan::Ticket ticket) noexcept;

  /// Looks again for who was cancelled.
  void wake();

  std::size_t capacity() const { return capacity_; }
  std::size_t device() const { return device_; }
  Schedule* schedule() const { return schedule_.get(); }
  double milliseconds() const { return std::chrono::duration<double, std::milli>(Clock::now() - epoch_).count(); }

private:
  void startAll();

  const std::size_t capacity_;
  const std::size_t device_;
  const std::shared_ptr<Schedule> schedule_;
  const Clock::time_point epoch_;
  std::mutex mutex_;
  std::condition_variable changed_;
  Plan plan_;
};

/// A lane's share of the device: what the pair that it aligns requests, and what that pair did.
class LaneShare : public DeviceShare {
public:
  LaneShare(Executor& executor, std::size_t lane)
  : executor_(executor)
  , lane_(lane)
  {
  }

  /// From now on requests are this pair's, until the next.
  void begin(std::size_t pair);
  /// Records that the pair has ended.
  void end();

  void cancel();
  bool cancelled() const { return cancelled_; }

  std::size_t capacity() const override { return executor_.capacity(); }
  Grant request(const char* operation, std::size_t work_items) override;
  void narrow(Grant grant, const char* operation, std::size_t work_items) override;
  void release(Grant grant) noexcept override;

private:
  void record(const char* what, std::size_t work_items, double begin_ms);

  Executor& executor_;
  const std::size_t lane_;
  std::atomic<bool> cancelled_{false};
  std::size_t pair_ = 0;
  double pair_begin_ms_ = 0;
  const char* operation_ = nullptr; ///< that runs,
  std::size_t work_items_ = 0;      ///< on so many work-items,
  double operation_begin_ms_ = 0;   ///< since then
};

} // namespace pcl_gpu_icp::scheduler
