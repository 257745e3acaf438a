#include "batch_run.h"

#include <pcl_gpu_icp/error.h>
#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <limits>
#include <system_error>
#include <thread>
#include <utility>

namespace pcl_gpu_icp {

using scheduler::Executor;
using scheduler::LaneShare;
using scheduler::Plan;

namespace {

constexpr unsigned most_lanes_by_default = 8;

BatchResult endedBy(Reason reason, const std::string& message)
{
  BatchResult result;
  result.alignment.reason = reason;
  result.alignment.message = message;
  result.alignment.error = std::current_exception();
  return result;
}

/// What the pair returns, or why it does not.
BatchResult outcomeOf(const BatchPair& align, DeviceLane& lane)
{
  try {
    return align(lane);
  } catch (const Cancelled& cancelled) {
    return endedBy(Reason::Cancelled, cancelled.what());
  } catch (const std::exception& error) {
    return endedBy(Reason::Error, error.what());
  } catch (...) {
    return endedBy(Reason::Error, "an exception that is no std::exception");
  }
}

/// Why the device no longer works; empty where it does.
std::string lossOf(const Device& device)
{
  try {
    const Matcher probe(device, CorrespondenceSearch::DeviceKdTree, Precision::Float);
    return "";
  } catch (const std::exception& error) {
    return error.what();
  }
}

std::size_t orUnlimited(std::size_t bound) { return bound > 0 ? bound : std::numeric_limits<std::size_t>::max(); }

} // namespace

BatchRun::BatchRun(std::vector<Pair> pairs, const BatchSettings& settings, std::size_t first, Finished finished)
: settings_(settings)
, first_(first)
, finished_(std::move(finished))
, pairs_(std::move(pairs))
, admission_(orUnlimited(settings.points_in_flight), settings.policy)
, lane_of_(pairs_.size(), nullptr)
, results_(settings.keep_results ? pairs_.size() : 0)
{
  for (const Pair& pair : pairs_)
    admission_.submit(pair.points);
}

std::vector<BatchResult> BatchRun::run(const std::vector<Device>& devices)
{
  const unsigned lanes =
      settings_.lanes > 0 ? settings_.lanes : std::min(2 * effectiveThreads(0), most_lanes_by_default);
  std::deque<Shared> shared;
  for (const Device& device : devices) {
    const std::size_t capacity = settings_.capacity > 0 ? settings_.capacity : device.info().workItemsAtOnce();
    shared.emplace_back(device, Plan(capacity, settings_.policy), shared.size(), *this);
  }
  // Pairs beyond the lanes would only wait, lanes beyond the pairs would have none.
  std::vector<std::thread> threads;
  const auto start = [&](std::size_t device, std::size_t lane) {
    threads.emplace_back([&, device, lane] { runLane(shared[device], lane); });
  };
  try {
    for (std::size_t lane = 0; lane < lanes; ++lane)
      for (std::size_t device = 0; device < devices.size(); ++device)
        if (lane + device > 0 && threads.size() + 1 < pairs_.size())
          start(device, lane);
  } catch (const std::system_error&) {
    // The system has no more threads to give: those there are do the work.
  }
  runLane(shared.front(), 0);
  for (std::thread& thread : threads)
    thread.join();

  // Lanes end early where their device was lost.
  while (const auto ticket = admission_.startNext())
    settle(*ticket - 1, endedBy(Reason::Error, "the device was lost: " + loss_));
  if (failure_)
    std::rethrow_exception(failure_);
  return std::move(results_);
}

void BatchRun::runLane(Shared& shared, std::size_t number)
{
  const Executor& executor = shared.executor;
  const auto share = std::make_shared<LaneShare>(shared.executor, number);
  DeviceLane lane(shared.device, share, shared.targets);
  while (const auto ticket = admitNext()) {
    const std::size_t pair = *ticket - 1;
    const double begin_ms = executor.milliseconds();
    BatchResult result = align(pair, lane, *share);
    result.device = executor.device();
    result.begin_ms = begin_ms;
    result.end_ms = executor.milliseconds();
    const bool failed = result.alignment.reason == Reason::Error;
    settle(pair, std::move(result));
    if (!failed || lane.matcher)
      continue;
    const std::string loss = lossOf(lane.device);
    if (!loss.empty()) {
      const std::lock_guard<std::mutex> lock(mutex_);
      loss_ = loss;
      return;
    }
  }
}

/// Waits until there is room for the next pair; nothing when none is left.
std::optional<Plan::Ticket> BatchRun::admitNext()
{
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    if (admission_.waiting() == 0)
      return std::nullopt;
    if (const auto ticket = admission_.startNext())
      return ticket;
    room_.wait(lock);
  }
}

BatchResult BatchRun::align(std::size_t pair, DeviceLane& lane, LaneShare& share)
{
  BatchPair work;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (pairs_[pair].cancelled)
      return endedBy(Reason::Cancelled, "cancelled");
    work = std::exchange(pairs_[pair].align, nullptr);
    share.begin(first_ + pair);
    lane_of_[pair] = &share;
  }
  BatchResult result = outcomeOf(work, lane);
  const std::lock_guard<std::mutex> lock(mutex_);
  lane_of_[pair] = nullptr;
  share.end();
  return result;
}

void BatchRun::settle(std::size_t pair, BatchResult result)
{
  const std::lock_guard<std::mutex> one_at_a_time(callback_);
  if (finished_ && !failure_) {
    try {
      finished_(pair, result);
    } catch (...) {
      failure_ = std::current_exception();
      cancel();
    }
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (settings_.keep_results)
    results_[pair] = std::move(result);
  admission_.end(pair + 1);
  room_.notify_all();
}

void BatchRun::cancelLocked(std::size_t pair)
{
  pairs_[pair].cancelled = true;
  if (lane_of_[pair])
    lane_of_[pair]->cancel();
}

void BatchRun::cancel()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  for (std::size_t pair = 0; pair < pairs_.size(); ++pair)
    cancelLocked(pair);
}

void BatchRun::cancel(std::size_t pair)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (pair < pairs_.size())
    cancelLocked(pair);
}

} // namespace pcl_gpu_icp
