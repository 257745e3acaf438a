#include <pcl_gpu_icp/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace pcl_gpu_icp {

unsigned effectiveThreads(unsigned threads)
{
  return threads > 0 ? threads : std::max(1U, std::thread::hardware_concurrency());
}

void parallelFor(std::size_t count,
                 std::size_t range_size,
                 unsigned threads,
                 const std::function<void(std::size_t, std::size_t)>& body)
{
  std::atomic<std::size_t> next{0};
  std::mutex failure_mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    try {
      for (std::size_t begin; (begin = next.fetch_add(range_size)) < count;)
        body(begin, std::min(begin + range_size, count));
    } catch (...) {
      next = count;
      const std::lock_guard<std::mutex> lock(failure_mutex);
      if (!failure)
        failure = std::current_exception();
    }
  };
  // Two ranges at least pay for starting another thread.
  const std::size_t useful = std::max<std::size_t>(1, count / (2 * range_size));
  std::vector<std::thread> helpers;
  try {
    for (std::size_t i = 1; i < std::min<std::size_t>(threads, useful); ++i)
      helpers.emplace_back(work);
  } catch (const std::system_error&) {
    // The system has no more threads to give: those there are do the work.
  }
  work();
  for (std::thread& helper : helpers)
    helper.join();
  if (failure)
    std::rethrow_exception(failure);
}

} // namespace pcl_gpu_icp
