#pragma once

#include <algorithm>
#include <csignal>
#include <exception>
#include <stdexcept>
#include <string>

namespace pcl_gpu_icp::cli {

enum class ExitCode {
  Success = 0,
  NotConverged = 1, ///< it ran, but did not converge, or the results compared differ
  Usage = 2,
  Input = 3,
  Device = 4,
  Output = 5,
  Internal = 70,
  Interrupted = 130, ///< by SIGINT, as shells number it
  Terminated = 143,  ///< by SIGTERM
};

/// How a command ends that a signal interrupts.
constexpr ExitCode interruptedBy(int signal) { return signal == SIGINT ? ExitCode::Interrupted : ExitCode::Terminated; }

constexpr const char* toString(ExitCode code)
{
  switch (code) {
  case ExitCode::Success:
    return "success";
  case ExitCode::NotConverged:
    return "not converged";
  case ExitCode::Usage:
    return "usage";
  case ExitCode::Input:
    return "input";
  case ExitCode::Device:
    return "device";
  case ExitCode::Output:
    return "output";
  case ExitCode::Internal:
    return "internal";
  case ExitCode::Interrupted:
  case ExitCode::Terminated:
    return "interrupted";
  }
  return "unknown";
}

/// Ends the command: what() is the one line for stderr and says what is wrong and where. What it quotes from a file may
/// have control characters, which become blanks.
class Failure : public std::runtime_error {
public:
  Failure(ExitCode code, const std::string& line)
  : std::runtime_error(onOneLine(line))
  , code_(code)
  {
  }
  ExitCode code() const noexcept { return code_; }

private:
  static std::string onOneLine(std::string line)
  {
    std::replace_if(
        line.begin(), line.end(), [](unsigned char c) { return c < ' ' || c == 0x7F; }, ' ');
    return line;
  }

  ExitCode code_;
};

/// How the command ends that throws `error`.
Failure failureOf(const std::exception_ptr& error);

} // namespace pcl_gpu_icp::cli
