#include "cli/command_names.h"

namespace pcl_gpu_icp::cli {

std::vector<std::string> commandsOf(const CLI::App& app)
{
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({}))
    names.push_back(command->get_name());
  return names;
}

std::vector<std::string> namesOf(const CLI::Option& option)
{
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames())
    names.push_back("-" + name);
  for (const std::string& name : option.get_lnames())
    names.push_back("--" + name);
  return names;
}

std::vector<std::string> optionsOf(const CLI::App& command)
{
  std::vector<std::string> all;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : namesOf(*option))
      all.push_back(name);
  return all;
}

} // namespace pcl_gpu_icp::cli
