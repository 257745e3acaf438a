#include "cli/this_run.h"

#include "report/format.h"

#include <pcl_gpu_icp/version.h>

#include <pcl/pcl_config.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace pcl_gpu_icp::cli {
namespace {

/// In quotes where a shell would not take it as it is.
std::string shellWord(const std::string& argument)
{
  const auto isPlain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || std::strchr("-_./=:,+@%", c);
  };
  const auto isPrintable = [](char c) { return c >= ' ' && c <= '~'; };
  if (!argument.empty() && std::all_of(argument.begin(), argument.end(), isPlain))
    return argument;
  const bool printable = std::all_of(argument.begin(), argument.end(), isPrintable);
  std::string text = printable ? "'" : "$'";
  for (const char c : argument)
    if (!isPrintable(c))
      text += report::format("\\%03o", static_cast<unsigned>(static_cast<unsigned char>(c)));
    else if (c == '\'')
      text += printable ? "'\\''" : "\\'";
    else if (c == '\\' && !printable)
      text += "\\\\";
    else
      text += c;
  return text + "'";
}

} // namespace

view::Repetition thisRun()
{
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string line;
  for (std::string argument; std::getline(file, argument, '\0');)
    line += (line.empty() ? "" : " ") + shellWord(argument);
  std::error_code error;
  return {line,
          std::filesystem::current_path(error).string(),
          "pcl_gpu_icp " PCL_GPU_ICP_VERSION ", PCL " PCL_VERSION_PRETTY};
}

} // namespace pcl_gpu_icp::cli
