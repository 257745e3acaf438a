#include "cli/command_line.h"
#include "cli/guess.h"
#include "cli/interruption.h"
#include "cli/usage_error.h"

#include <pcl/console/print.h>

#include <algorithm>
#include <csignal>
#include <cstdio>

namespace pcl_gpu_icp::cli {
namespace {

int fail(ExitCode code, std::string line)
{
  std::replace(line.begin(), line.end(), '\n', ' ');
  std::fprintf(stderr, "pcl_gpu_icp: %s\n", line.c_str());
  return static_cast<int>(code);
}

int run(int argc, char** argv)
{
  Run command;
  const auto app = makeCommandLine(command);
  std::vector<std::string> arguments = joinGuess({argv + 1, argv + argc});
  std::reverse(arguments.begin(), arguments.end()); // as CLI11 takes them
  try {
    app->parse(arguments);
  } catch (const CLI::Success& request) { // --help, --version
    return app->exit(request);
  } catch (const CLI::ParseError& error) {
    return fail(ExitCode::Usage, usageErrorText(*app, error) + " (see --help)");
  }
  return static_cast<int>(command());
}

} // namespace
} // namespace pcl_gpu_icp::cli

int main(int argc, char** argv)
{
  using namespace pcl_gpu_icp;
  cli::Interruption::holdBack();
  // A file size limit shall be an error of write(), which is reported.
  std::signal(SIGXFSZ, SIG_IGN);
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  try {
    return cli::run(argc, argv);
  } catch (...) {
    const cli::Failure failure = cli::failureOf(std::current_exception());
    return cli::fail(failure.code(), failure.what());
  }
}
