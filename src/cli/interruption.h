#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace pcl_gpu_icp::cli {

/// Turns the first SIGINT or SIGTERM into a call while it lives; a second one ends the process. One that the process
/// ignores stays ignored. There is one at a time.
class Interruption {
public:
  /// Holds both signals back from this thread and those that it starts, until there is an Interruption. To be called
  /// first, and before OpenCL is: a compiler in it would take a signal as the order to remove the files it is writing,
  /// and a linker that it runs would end.
  static void holdBack();

  /// \param on_interrupt called with the signal, by a thread of its own
  explicit Interruption(std::function<void(int)> on_interrupt);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// 0: none came.
  int signal() const;

private:
  void wait(const std::function<void(int)>& on_interrupt);

  mutable std::mutex mutex_;
  std::condition_variable ends_;
  bool ending_ = false;
  int signal_ = 0;
  std::thread thread_;
};

/// What a command does that has nothing to finish: ends the process, leaving no temporary file. For an Interruption.
[[noreturn]] void endAtOnce(int signal);

} // namespace pcl_gpu_icp::cli
