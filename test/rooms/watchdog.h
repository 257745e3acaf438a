#pragma once

#include <chrono>
#include <cstdlib>
#include <future>
#include <iostream>
#include <thread>

namespace pcl_gpu_icp::test {

/// Ends the process when what it guards hangs: nothing else would.
class Watchdog {
public:
  explicit Watchdog(std::chrono::seconds limit = std::chrono::seconds(300))
  : thread_([this, limit] {
    if (over_.get_future().wait_for(limit) == std::future_status::timeout) {
      std::cerr << "hangs" << std::endl;
      std::abort();
    }
  })
  {
  }
  ~Watchdog()
  {
    over_.set_value();
    thread_.join();
  }
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

private:
  std::promise<void> over_;
  std::thread thread_;
};

} // namespace pcl_gpu_icp::test
