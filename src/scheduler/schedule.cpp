#include <pcl_gpu_icp/schedule.h>

#include <new>
#include <utility>

namespace pcl_gpu_icp {

const char* toString(Policy policy)
{
  switch (policy) {
  case Policy::SmallestFirst:
    return "smallest";
  case Policy::FirstComeFirstServed:
    return "fifo";
  case Policy::LargestFirst:
    return "largest";
  }
  return "unknown";
}

namespace {

template <typename Entry>
void append(std::vector<Entry>& entries, Entry entry) noexcept
{
  try {
    entries.push_back(std::move(entry));
  } catch (const std::bad_alloc&) {
    return;
  }
}

} // namespace

void Schedule::add(Span span) noexcept
{
  const std::lock_guard<std::mutex> lock(mutex_);
  append(spans_, std::move(span));
}

void Schedule::add(const Level& level) noexcept
{
  const std::lock_guard<std::mutex> lock(mutex_);
  append(levels_, level);
}

std::vector<Schedule::Span> Schedule::spans() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return spans_;
}

std::vector<Schedule::Level> Schedule::levels() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return levels_;
}

} // namespace pcl_gpu_icp
