#include "cli/interruption.h"

#include "cli/failure.h"
#include "cli/output_file.h"

#include <csignal>
#include <unistd.h>
#include <utility>

namespace pcl_gpu_icp::cli {
namespace {

bool isIgnored(int number)
{
  struct sigaction action {};
  return sigaction(number, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

/// Those held back that the process did not ignore before a compiler in it had handlers of its own.
sigset_t heeded;

/// Of the thread that waits: what the others wake it with. A signal of the process is no different.
constexpr int wake_signal = SIGTERM;

} // namespace

void Interruption::holdBack()
{
  sigset_t both;
  sigemptyset(&both);
  sigemptyset(&heeded);
  for (const int number : {SIGINT, SIGTERM}) {
    sigaddset(&both, number);
    if (!isIgnored(number))
      sigaddset(&heeded, number);
  }
  pthread_sigmask(SIG_BLOCK, &both, nullptr);
}

Interruption::Interruption(std::function<void(int)> on_interrupt)
: thread_([this, on_interrupt = std::move(on_interrupt)] { wait(on_interrupt); })
{
}

Interruption::~Interruption()
{
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
    if (signal_ == 0)
      pthread_kill(thread_.native_handle(), wake_signal);
  }
  ends_.notify_one();
  thread_.join();
}

int Interruption::signal() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return signal_;
}

void Interruption::wait(const std::function<void(int)>& on_interrupt)
{
  sigset_t awaited = heeded;
  sigaddset(&awaited, wake_signal);
  int number = 0;
  for (;;) {
    sigwait(&awaited, &number);
    const std::lock_guard<std::mutex> lock(mutex_);
    if (ending_)
      return;
    if (sigismember(&heeded, number) != 0) {
      signal_ = number;
      break;
    }
  }
  on_interrupt(number);
  pthread_sigmask(SIG_UNBLOCK, &heeded, nullptr); // so that a second one has its usual effect
  std::unique_lock<std::mutex> lock(mutex_);
  ends_.wait(lock, [this] { return ending_; });
}

void endAtOnce(int signal)
{
  OutputFile::endAll();
  _exit(static_cast<int>(interruptedBy(signal)));
}

} // namespace pcl_gpu_icp::cli
