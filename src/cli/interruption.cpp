#include "cli/interruption.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace pcl_gpu_icp::cli {
namespace {

constexpr std::array<int, 2> signals{SIGINT, SIGTERM};

// What a signal handler can reach.
std::atomic<int> received{0};
std::array<int, 2> channel{-1, -1}; ///< of a pipe: where a handler says that one came

void wake()
{
  const char byte = 0;
  while (write(channel[1], &byte, 1) < 0 && errno == EINTR) {
  }
}

void handle(int number, void (*handler)(int))
{
  struct sigaction action {};
  if (sigaction(number, nullptr, &action) == 0 && action.sa_handler == SIG_IGN)
    return;
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(number, &action, nullptr);
}

extern "C" void onSignal(int number)
{
  const int error = errno;
  for (const int each : signals)
    handle(each, SIG_DFL);
  received = number;
  wake();
  errno = error;
}

void waitForWake()
{
  char byte;
  while (read(channel[0], &byte, 1) < 0 && errno == EINTR) {
  }
}

} // namespace

Interruption::Interruption(std::function<void()> on_interrupt)
{
  received = 0;
  if (pipe(channel.data()) != 0)
    throw std::system_error(errno, std::generic_category(), "pipe");
  thread_ = std::thread([on_interrupt = std::move(on_interrupt)] {
    waitForWake();
    if (received != 0)
      on_interrupt();
  });
  for (const int number : signals)
    handle(number, onSignal);
}

Interruption::~Interruption()
{
  for (const int number : signals)
    handle(number, SIG_DFL);
  wake();
  thread_.join();
  for (int& end : channel)
    close(std::exchange(end, -1));
}

int Interruption::signal() const { return received; }

} // namespace pcl_gpu_icp::cli
