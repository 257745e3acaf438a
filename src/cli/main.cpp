#include "cli/commands.h"
#include "cli/guess.h"
#include "cli/interruption.h"

#include <pcl_gpu_icp/version.h>

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
  CLI::App app("Aligns point clouds with ICP on an OpenCL device.", "pcl_gpu_icp");
  app.set_version_flag("--version", "pcl_gpu_icp " PCL_GPU_ICP_VERSION);
  app.require_subcommand(1);
  app.footer("Exit status: 0 converged or at the iteration limit, 1 ran but has no answer (compare: or the results "
             "differ), 2 usage, 3 input, 4 device, 5 output, 70 internal error, 130 or 143 interrupted.");
  Run command;
  const auto add = [&](const char* name, const char* description, Run (*build)(CLI::App&)) {
    CLI::App* subcommand = app.add_subcommand(name, description);
    subcommand->callback([&command, run = build(*subcommand)] { command = run; });
  };
  add("align", "Move SOURCE onto TARGET", addAlign);
  add("batch", "Align the pairs of a manifest, or the scans of a sequence, many at once", addBatch);
  add("compare", "Run stock PCL and pcl_gpu_icp with the same settings", addCompare);
  add("devices", "List the OpenCL devices and the one that would be chosen", addDevices);

  std::vector<std::string> arguments = joinGuess({argv + 1, argv + argc});
  std::reverse(arguments.begin(), arguments.end()); // as CLI11 takes them
  try {
    app.parse(arguments);
  } catch (const CLI::Success& request) { // --help, --version
    return app.exit(request);
  } catch (const CLI::ParseError& error) {
    if (app.get_subcommands().empty() && !app.remaining().empty())
      return fail(ExitCode::Usage, "there is no subcommand " + app.remaining().front() + " (see --help)");
    return fail(ExitCode::Usage, std::string(error.what()) + " (see --help)");
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
