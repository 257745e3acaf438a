#include <pcl_gpu_icp/batch_lanes.h>

#include "batch_run.h"

#include <pcl_gpu_icp/error.h>

#include <mutex>
#include <utility>

namespace pcl_gpu_icp {

struct BatchLanes::Implementation {
  std::mutex mutex;
  std::vector<BatchRun::Pair> added; ///< since the last run
  std::size_t first = 0;             ///< number of the first of these, or of those that run
  BatchRun* running = nullptr;
};

BatchLanes::BatchLanes()
: implementation_(std::make_unique<Implementation>())
{
}

BatchLanes::~BatchLanes() = default;

std::size_t BatchLanes::add(std::size_t points, BatchPair pair)
{
  Implementation& self = *implementation_;
  if (!pair)
    throw InvalidArgument("a pair of a batch needs a function that aligns it");
  const std::lock_guard<std::mutex> lock(self.mutex);
  if (self.running)
    throw InvalidArgument("a pair was added to a batch that runs");
  self.added.push_back({points, std::move(pair)});
  return self.first + self.added.size() - 1;
}

std::size_t BatchLanes::size() const
{
  const std::lock_guard<std::mutex> lock(implementation_->mutex);
  return implementation_->added.size();
}

std::vector<BatchResult> BatchLanes::run(const std::vector<Device>& devices,
                                         const BatchSettings& settings,
                                         const std::function<void(std::size_t pair, const BatchResult&)>& finished)
{
  Implementation& self = *implementation_;
  if (devices.empty())
    throw InvalidArgument("a batch needs a device");
  std::unique_lock<std::mutex> lock(self.mutex);
  if (self.running)
    throw InvalidArgument("the batch runs already");
  const std::size_t count = self.added.size(), first = self.first;
  BatchRun::Finished numbered;
  if (finished)
    numbered = [&](std::size_t pair, const BatchResult& result) { finished(first + pair, result); };
  BatchRun run(std::exchange(self.added, {}), settings, first, std::move(numbered));
  self.running = &run;
  lock.unlock();

  const auto end = [&] {
    lock.lock();
    self.running = nullptr;
    self.first += count;
  };
  try {
    std::vector<BatchResult> results = run.run(devices);
    end();
    return results;
  } catch (...) {
    end();
    throw;
  }
}

void BatchLanes::cancel()
{
  const std::lock_guard<std::mutex> lock(implementation_->mutex);
  for (BatchRun::Pair& pair : implementation_->added)
    pair.cancelled = true;
  if (implementation_->running)
    implementation_->running->cancel();
}

void BatchLanes::cancel(std::size_t pair)
{
  Implementation& self = *implementation_;
  const std::lock_guard<std::mutex> lock(self.mutex);
  if (pair < self.first)
    return;
  if (self.running)
    self.running->cancel(pair - self.first);
  else if (pair - self.first < self.added.size())
    self.added[pair - self.first].cancelled = true;
}

} // namespace pcl_gpu_icp
