#include "cli/compilation_notice.h"

#include "report/format.h"

#include <pcl_gpu_icp/device.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>

namespace pcl_gpu_icp::cli {
namespace {

constexpr const char* what = "compiling kernels for this device, once";
// More than a later start takes, which fetches them, on a busy machine too.
constexpr CompilationNotice::Patience usual{std::chrono::milliseconds(500), std::chrono::seconds(10)};

} // namespace

CompilationNotice::CompilationNotice(LiveLine& line, bool wanted, Patience patience, std::function<bool()> is_compiling)
: line_(line)
, patience_(patience)
, is_compiling_(std::move(is_compiling))
{
  if (wanted)
    thread_ = std::thread([this] { watch(); });
}

CompilationNotice::CompilationNotice(LiveLine& line, bool wanted)
: CompilationNotice(line, wanted, usual, isCompilingKernels)
{
}

CompilationNotice::~CompilationNotice()
{
  if (!thread_.joinable())
    return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    has_ended_ = true;
  }
  ended_.notify_all();
  thread_.join();
}

void CompilationNotice::watch()
{
  using Clock = std::chrono::steady_clock;
  const std::chrono::milliseconds interval = std::min(patience_.on_terminal, std::chrono::milliseconds(100));
  Clock::duration spent{};
  bool covers = false, told = false;
  std::unique_lock<std::mutex> lock(mutex_);
  for (auto last = Clock::now(); !ended_.wait_for(lock, interval, [this] { return has_ended_; });) {
    const auto now = Clock::now();
    const bool compiles = is_compiling_();
    if (compiles)
      spent += now - last;
    last = now;
    const bool covered = std::exchange(covers, line_.isShown() && compiles && spent >= patience_.on_terminal);
    if (covers)
      line_.cover(std::string(what) + report::format(": %.0f s", std::chrono::duration<double>(spent).count()));
    else if (covered)
      line_.uncover();
    if (!line_.isShown() && !told && spent >= patience_.elsewhere) {
      told = true;
      std::fprintf(stderr, "pcl_gpu_icp: %s: later starts do without\n", what);
    }
  }
  if (covers)
    line_.uncover();
}

} // namespace pcl_gpu_icp::cli
