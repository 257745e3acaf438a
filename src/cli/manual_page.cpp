#include "cli/manual_page.h"

#include "cli/command_names.h"
#include "cli/help.h"
#include "cli/option_values.h"

#include <pcl_gpu_icp/version.h>

#include <sstream>

namespace pcl_gpu_icp::cli {
namespace {

/// What roff shows as it is here.
std::string plain(const std::string& text)
{
  std::string shown;
  for (const char c : text)
    shown += c == '\\' ? "\\e" : c == '-' ? "\\-" : c == '\'' ? "\\(aq" : std::string(1, c);
  return (shown.rfind('.', 0) == 0 ? "\\&" : "") + shown;
}

std::string bold(const std::string& text) { return "\\fB" + plain(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + plain(text) + "\\fR"; }

std::string optionText(const CLI::Option& option)
{
  std::string names;
  for (const std::string& name : namesOf(option))
    names += (names.empty() ? "" : ", ") + bold(name);
  if (option.get_positional())
    names = italic(option.get_name(true));
  else if (valuesOf(option).any)
    names += " " + italic(option.get_type_name());
  if (!option.get_default_str().empty())
    names += plain(" (" + option.get_default_str() + ")");
  return ".TP\n" + names + "\n" + plain(option.get_description()) + "\n";
}

std::string footerText(const CLI::App& app)
{
  std::string text = ".PP\n.nf\n";
  std::istringstream lines(app.get_footer());
  for (std::string line; std::getline(lines, line);)
    text += line.empty() ? ".sp\n" : plain(line) + "\n";
  return text + ".fi\n";
}

std::string commandText(const CLI::App& command)
{
  std::string text = ".SH \"" + plain(command.get_name()) + "\"\n" + plain(command.get_description()) + ".\n";
  for (const CLI::Option* option : command.get_options([](const CLI::Option* o) { return o->get_positional(); }))
    text += optionText(*option);
  for (const char* name : group::all) {
    std::string options;
    for (const CLI::Option* option :
         command.get_options([name](const CLI::Option* o) { return o->get_group() == name && !o->get_positional(); }))
      options += optionText(*option);
    if (!options.empty())
      text += std::string(".SS \"") + name + "\"\n" + options;
  }
  return text + footerText(command);
}

std::string synopsisOf(const CLI::App& command)
{
  std::string text = bold("pcl_gpu_icp " + command.get_name()) + " [" + italic("OPTIONS") + "]";
  for (const CLI::Option* option : command.get_options([](const CLI::Option* o) { return o->get_positional(); })) {
    const std::string name = italic(option->get_name(true));
    text += " " + (option->get_required() ? name : "[" + name + "]");
  }
  return text + "\n";
}

} // namespace

std::string manualPage(const CLI::App& app, const std::string& date)
{
  std::string text = ".TH PCL_GPU_ICP 1 \"" + date +
                     "\" \"pcl_gpu_icp " PCL_GPU_ICP_VERSION "\" \"User Commands\"\n"
                     ".SH NAME\npcl_gpu_icp \\- aligns point clouds with ICP on an OpenCL device\n.SH SYNOPSIS\n";
  const auto commands = app.get_subcommands({});
  for (const CLI::App* command : commands)
    text += synopsisOf(*command) + ".br\n";
  text += bold("pcl_gpu_icp") + " " + bold("--help") + " | " + bold("--version") + "\n";
  text += ".SH DESCRIPTION\n" + plain(app.get_description()) + "\n" + footerText(app);
  for (const CLI::App* command : commands)
    text += commandText(*command);
  return text;
}

} // namespace pcl_gpu_icp::cli
