#include "executor.h"

#include <algorithm>
#include <utility>

namespace pcl_gpu_icp::scheduler {

Executor::Executor(Plan plan, std::size_t device, std::shared_ptr<Schedule> schedule, Clock::time_point epoch)
: capacity_(plan.capacity())
, device_(device)
, schedule_(std::move(schedule))
, epoch_(epoch)
, plan_(std::move(plan))
{
}

Plan::Ticket Executor::start(std::size_t request, const std::atomic<bool>& cancelled)
{
  std::unique_lock<std::mutex> lock(mutex_);
  const Plan::Ticket ticket = plan_.submit(request);
  startAll();
  changed_.wait(lock, [&] { return plan_.held(ticket) > 0 || cancelled; });
  if (plan_.held(ticket) > 0)
    return ticket;
  plan_.end(ticket);
  startAll();
  throw Cancelled("cancelled");
}

void Executor::narrow(Plan::Ticket ticket, std::size_t kept)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  plan_.narrow(ticket, kept);
  startAll();
}

void Executor::end(Plan::Ticket ticket) noexcept
{
  const std::lock_guard<std::mutex> lock(mutex_);
  plan_.end(ticket);
  startAll();
}

void Executor::wake()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  changed_.notify_all();
}

void Executor::startAll()
{
  while (plan_.startNext())
    changed_.notify_all();
  if (schedule_)
    schedule_->add(Schedule::Level{device_, milliseconds(), plan_.idle(), plan_.waiting()});
}

void LaneShare::begin(std::size_t pair)
{
  cancelled_ = false;
  pair_ = pair;
  pair_begin_ms_ = executor_.milliseconds();
}

void LaneShare::end() { record("pair", 0, pair_begin_ms_); }

void LaneShare::cancel()
{
  cancelled_ = true;
  executor_.wake();
}

DeviceShare::Grant LaneShare::request(const char* operation, std::size_t work_items)
{
  if (cancelled_)
    throw Cancelled("cancelled");
  const Grant grant = executor_.start(work_items, cancelled_);
  operation_ = operation;
  work_items_ = std::min(work_items, executor_.capacity());
  operation_begin_ms_ = executor_.milliseconds();
  return grant;
}

void LaneShare::narrow(Grant grant, const char* operation, std::size_t work_items)
{
  if (operation == operation_ && work_items == work_items_)
    return;
  record(operation_, work_items_, operation_begin_ms_);
  operation_ = operation;
  operation_begin_ms_ = executor_.milliseconds();
  if (std::exchange(work_items_, work_items) != work_items)
    executor_.narrow(grant, work_items);
}

void LaneShare::release(Grant grant) noexcept
{
  record(operation_, work_items_, operation_begin_ms_);
  executor_.end(grant);
}

void LaneShare::record(const char* what, std::size_t work_items, double begin_ms)
{
  if (Schedule* schedule = executor_.schedule())
    schedule->add({executor_.device(), lane_, pair_, what, work_items, begin_ms, executor_.milliseconds()});
}

} // namespace pcl_gpu_icp::scheduler
