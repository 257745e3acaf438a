#include "cli/this_run.h"

#include "cli/input_file.h"

#include "report/format.h"
#include "view/text.h"

#include <pcl_gpu_icp/version.h>

#include <pcl/pcl_config.h>

#include <filesystem>
#include <fstream>

namespace pcl_gpu_icp::cli {
namespace {

/// As a shell takes it, with escapes for what cannot be shown.
std::string escaped(const std::string& argument)
{
  std::string text = "$'";
  for (const char c : argument)
    if (c < ' ' || c > '~')
      text += report::format("\\%03o", static_cast<unsigned>(static_cast<unsigned char>(c)));
    else
      text += (c == '\'' || c == '\\' ? "\\" : "") + std::string(1, c);
  return text + "'";
}

std::string argumentText(const std::string& argument)
{
  if (view::lineOf(argument) != argument)
    return escaped(argument);
  const std::size_t dashes = std::min(argument.find_first_not_of('-'), argument.size());
  const std::string rest = argument.substr(dashes);
  return !rest.empty() && shellWord(rest) == rest ? argument : shellWord(argument);
}

} // namespace

std::vector<std::string> argumentsOfThisRun()
{
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> arguments;
  for (std::string argument; std::getline(file, argument, '\0');)
    arguments.push_back(argument);
  return arguments;
}

view::Repetition thisRun()
{
  std::string line;
  for (const std::string& argument : argumentsOfThisRun())
    line += (line.empty() ? "" : " ") + argumentText(argument);
  std::error_code error;
  return {line,
          std::filesystem::current_path(error).string(),
          "pcl_gpu_icp " PCL_GPU_ICP_VERSION ", PCL " PCL_VERSION_PRETTY};
}

} // namespace pcl_gpu_icp::cli
