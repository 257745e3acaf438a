#pragma once

#include "cli/live_line.h"

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace pcl_gpu_icp::cli {

/// While it lives, says that kernels are compiled where that takes long: over the live line with the seconds, and where
/// there is none once on stderr.
class CompilationNotice {
public:
  struct Patience {
    std::chrono::milliseconds on_terminal;
    std::chrono::milliseconds elsewhere;
  };

  /// \param wanted else it says nothing
  /// \param is_compiling asked again and again, by a thread of its own
  CompilationNotice(LiveLine& line, bool wanted, Patience patience, std::function<bool()> is_compiling);
  /// Of this process's kernels.
  CompilationNotice(LiveLine& line, bool wanted);
  ~CompilationNotice();
  CompilationNotice(const CompilationNotice&) = delete;
  CompilationNotice& operator=(const CompilationNotice&) = delete;

private:
  void watch();

  LiveLine& line_;
  const Patience patience_;
  const std::function<bool()> is_compiling_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool has_ended_ = false;
  std::thread thread_;
};

} // namespace pcl_gpu_icp::cli
