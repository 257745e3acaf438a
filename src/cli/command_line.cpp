#include "cli/command_line.h"

#include "cli/help.h"

#include <pcl_gpu_icp/version.h>

namespace pcl_gpu_icp::cli {

std::unique_ptr<CLI::App> makeCommandLine(Run& chosen)
{
  auto app = std::make_unique<CLI::App>("Aligns point clouds with ICP on an OpenCL device.", "pcl_gpu_icp");
  app->formatter(std::make_shared<HelpFormatter>());
  app->option_defaults()->group(group::advanced); // help shows no options but those of its groups
  app->get_help_ptr()->group(group::common);
  app->set_version_flag("--version", "pcl_gpu_icp " PCL_GPU_ICP_VERSION)->group(group::common);
  app->require_subcommand(1);
  const auto add = [&](const char* name, const char* description, Run (*build)(CLI::App&)) {
    CLI::App* command = app->add_subcommand(name, description)->group("Commands");
    command->get_help_ptr()->group(group::common);
    command->callback([&chosen, run = build(*command)] { chosen = run; });
  };
  add("align", "Move SOURCE onto TARGET", addAlign);
  add("batch", "Align many pairs at once: a manifest's, or a sequence's", addBatch);
  add("compare", "Run stock PCL and pcl_gpu_icp with the same settings", addCompare);
  add("devices", "List the OpenCL devices and the one that would be chosen", addDevices);
  app->footer(exampleText({{"Move one scan onto another and see whether to believe the result",
                            "pcl_gpu_icp align source.pcd target.pcd -o aligned.pcd"}}) +
              "\n\npcl_gpu_icp COMMAND --help has the options of a command.\n" +
              wrapped("Exit status: 0 converged or at the iteration limit, 1 ran but has no answer (compare: or the "
                      "results differ), 2 usage, 3 input, 4 device, 5 output, 70 internal error, 130 or 143 "
                      "interrupted.",
                      0));
  return app;
}

} // namespace pcl_gpu_icp::cli
