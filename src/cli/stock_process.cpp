#include "cli/stock_process.h"

#include "cli/failure.h"

#include "report/format.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <limits>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <type_traits>
#include <unistd.h>

namespace pcl_gpu_icp::cli {
namespace {

using Clock = std::chrono::steady_clock;
using report::Run;
using Normal = StockProcess::Normals::value_type;
static_assert(std::is_trivially_copyable_v<Run>, "goes from process to process as its bytes");

enum class Kind : char { Run, Failure };

/// False where the other side has ended, or `deadline` comes first.
bool receive(int socket, void* memory, std::size_t bytes, Clock::time_point deadline = Clock::time_point::max())
{
  auto* to = static_cast<char*>(memory);
  while (bytes > 0) {
    if (deadline != Clock::time_point::max()) {
      if (Clock::now() >= deadline)
        return false;
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count() + 1;
      pollfd waiting{socket, POLLIN, 0};
      const int ready =
          poll(&waiting, 1, static_cast<int>(std::clamp<long long>(left, 0, std::numeric_limits<int>::max())));
      if (ready <= 0)
        continue;
    }
    const ssize_t received = recv(socket, to, bytes, 0);
    if (received < 0 && errno == EINTR)
      continue;
    if (received <= 0)
      return false;
    to += received;
    bytes -= static_cast<std::size_t>(received);
  }
  return true;
}

/// False where the other side has ended.
bool send(int socket, const void* memory, std::size_t bytes)
{
  const auto* from = static_cast<const char*>(memory);
  while (bytes > 0) {
    const ssize_t sent = ::send(socket, from, bytes, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR)
      continue;
    if (sent < 0)
      return false;
    from += sent;
    bytes -= static_cast<std::size_t>(sent);
  }
  return true;
}

void sendFailure(int socket, const std::string& why)
{
  const Kind kind = Kind::Failure;
  const std::size_t size = why.size();
  send(socket, &kind, sizeof(kind));
  send(socket, &size, sizeof(size));
  send(socket, why.data(), size);
}

void answer(int socket, const std::function<Run(const StockProcess::Normals&)>& run)
{
  std::size_t count = 0;
  if (!receive(socket, &count, sizeof(count)))
    return;
  StockProcess::Normals normals(count);
  if (!receive(socket, normals.data(), count * sizeof(Normal)))
    return;
  const Run result = run(normals);
  const Kind kind = Kind::Run;
  send(socket, &kind, sizeof(kind));
  send(socket, &result, sizeof(result));
}

/// What it prints on its way out, and a core file, are of no use to the user.
void becomeSilent()
{
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
}

} // namespace

StockProcess::StockProcess(const std::function<Run(const Normals&)>& run)
{
  const auto fail = [] {
    throw Failure(ExitCode::Internal, std::string("no process for stock PCL: ") + std::strerror(errno));
  };
  int sockets[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets) != 0)
    fail();
  const pid_t parent = getpid();
  process_ = fork();
  if (process_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    close(sockets[0]);
    becomeSilent();
    try {
      if (getppid() == parent)
        answer(sockets[1], run);
    } catch (const std::exception& error) {
      sendFailure(sockets[1], error.what());
    }
    _exit(0); // nothing of the copy is to be destroyed
  }
  close(sockets[1]);
  socket_ = sockets[0];
  if (process_ < 0) {
    close(socket_);
    fail();
  }
}

StockProcess::~StockProcess()
{
  close(socket_);
  if (process_ > 0) {
    kill(process_, SIGKILL);
    howItEnded();
  }
}

StockProcess::Answer StockProcess::ask(const Normals& normals, std::chrono::duration<double> limit)
{
  const std::size_t count = normals.size();
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(limit);
  const auto received = [&](void* memory, std::size_t bytes) { return receive(socket_, memory, bytes, deadline); };
  send(socket_, &count, sizeof(count));
  send(socket_, normals.data(), count * sizeof(Normal));
  Kind kind;
  Run run;
  std::size_t size = 0;
  if (received(&kind, sizeof(kind))) {
    if (kind == Kind::Run && received(&run, sizeof(run)))
      return run;
    if (kind == Kind::Failure && received(&size, sizeof(size))) {
      std::string why(size, ' ');
      if (received(why.data(), size))
        return why;
    }
  }
  if (Clock::now() >= deadline)
    return report::format("no end within %g s", limit.count());
  return howItEnded();
}

std::string StockProcess::howItEnded()
{
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR)
    ;
  process_ = -1;
  if (WIFSIGNALED(status))
    return report::format("its process was ended by signal %d (%s)", WTERMSIG(status), strsignal(WTERMSIG(status)));
  return report::format("its process ended with code %d", WEXITSTATUS(status));
}

} // namespace pcl_gpu_icp::cli
