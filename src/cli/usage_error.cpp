#include "cli/usage_error.h"

#include "cli/command_names.h"
#include "cli/nearest_name.h"

#include <algorithm>

namespace pcl_gpu_icp::cli {

std::string usageErrorText(const CLI::App& app, const CLI::ParseError& error)
{
  const auto chosen = app.get_subcommands();
  const CLI::App& command = chosen.empty() ? app : *chosen.front();
  const std::vector<std::string> unknown = command.remaining();
  const auto option = std::find_if(
      unknown.begin(), unknown.end(), [](const std::string& argument) { return argument.rfind("--", 0) == 0; });
  if (option != unknown.end()) {
    const std::string name = option->substr(0, option->find('='));
    return "there is no option " + name + didYouMean(name, optionsOf(command));
  }
  if (chosen.empty() && !unknown.empty())
    return "there is no subcommand " + unknown.front() + didYouMean(unknown.front(), commandsOf(app));
  return error.what();
}

} // namespace pcl_gpu_icp::cli
