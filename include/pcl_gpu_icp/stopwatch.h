#pragma once

#include <pcl_gpu_icp/result.h>

#include <chrono>

namespace pcl_gpu_icp {

/// Adds the time from its construction to its destruction to an entry of StageTimes.
class Stopwatch {
public:
  Stopwatch(StageTimes& times, const char* what)
  : entry_(times[what])
  {
  }
  ~Stopwatch()
  {
    entry_.milliseconds += std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
    ++entry_.count;
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

private:
  using Clock = std::chrono::steady_clock;
  StageTime& entry_;
  Clock::time_point start_ = Clock::now();
};

} // namespace pcl_gpu_icp
