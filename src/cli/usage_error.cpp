#include "cli/usage_error.h"

#include "cli/command_names.h"
#include "cli/nearest_name.h"

#include <algorithm>
#include <cctype>
#include <map>

namespace pcl_gpu_icp::cli {
namespace {

/// Not a negative number.
bool isOption(const std::string& argument)
{
  return argument.size() > 1 && argument[0] == '-' &&
         (argument[1] == '-' || std::isalpha(static_cast<unsigned char>(argument[1])));
}

/// What is called so by other programs that align; empty: nothing.
std::string ourNameOf(const std::string& name)
{
  static const std::map<std::string, std::string> ours{{"-q", "--quiet"},
                                                       {"-v", "--verbose"},
                                                       {"-i", "--iterations"},
                                                       {"--max-iter", "--iterations"},
                                                       {"--max-iterations", "--iterations"},
                                                       {"--voxel", "--leaf"},
                                                       {"--voxel-size", "--leaf"},
                                                       {"--downsample", "--leaf"},
                                                       {"--downsampling-resolution", "--leaf"},
                                                       {"--init", "--guess"},
                                                       {"--initial", "--guess"},
                                                       {"--initial-guess", "--guess"},
                                                       {"--method", "--metric"},
                                                       {"--algorithm", "--metric"},
                                                       {"--registration-type", "--metric"},
                                                       {"--max-corr-dist", "--max-distance"},
                                                       {"--max-correspondence-distance", "--max-distance"},
                                                       {"--kernel", "--loss"}};
  const auto found = ours.find(name);
  return found == ours.end() ? "" : found->second;
}

} // namespace

std::string usageErrorText(const CLI::App& app, const CLI::ParseError& error)
{
  const auto chosen = app.get_subcommands();
  const CLI::App& command = chosen.empty() ? app : *chosen.front();
  const std::vector<std::string> unknown = command.remaining();
  const auto option = std::find_if(unknown.begin(), unknown.end(), isOption);
  if (option != unknown.end()) {
    const std::string name = option->substr(0, option->find('='));
    const auto options = optionsOf(command);
    const std::string ours = ourNameOf(name);
    const bool has_ours = std::find(options.begin(), options.end(), ours) != options.end();
    return "there is no option " + name + (has_ours ? proposal(ours) : didYouMean(name, options));
  }
  if (chosen.empty() && !unknown.empty())
    return "there is no subcommand " + unknown.front() + didYouMean(unknown.front(), commandsOf(app));
  return error.what();
}

} // namespace pcl_gpu_icp::cli
