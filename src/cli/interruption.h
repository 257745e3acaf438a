#pragma once

#include <functional>
#include <thread>

namespace pcl_gpu_icp::cli {

/// Turns the first SIGINT or SIGTERM into a call while it lives; a second one ends the process. One that the process
/// ignores stays ignored.
class Interruption {
public:
  /// \param on_interrupt called by a thread of its own
  explicit Interruption(std::function<void()> on_interrupt);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// 0: none came.
  int signal() const;

private:
  std::thread thread_;
};

} // namespace pcl_gpu_icp::cli
