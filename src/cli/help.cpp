#include "cli/help.h"

#include <sstream>
#include <utility>

namespace pcl_gpu_icp::cli {
namespace {

constexpr std::size_t width = 80;

/// A name, and from that column on what there is to say of it.
std::string entryText(const std::string& name, const std::string& text, std::size_t column)
{
  const std::string start = "  " + name;
  const bool fits = start.size() < column;
  return start + (fits ? "" : "\n") + std::string(column - (fits ? start.size() : 0), ' ') + wrapped(text, column) +
         "\n";
}

} // namespace

std::string exampleText(std::initializer_list<Example> examples)
{
  std::string text = "Examples:";
  for (const Example& example : examples)
    text += std::string("\n  ") + example.purpose + ":\n    " + example.line;
  return text;
}

std::string wrapped(const std::string& text, std::size_t column)
{
  std::istringstream words(text);
  std::string lines, word;
  std::size_t end = column;
  while (words >> word) {
    if (end > column && end + 1 + word.size() > width) {
      lines += "\n" + std::string(column, ' ');
      end = column;
    }
    else if (end > column) {
      lines += ' ';
      ++end;
    }
    lines += word;
    end += word.size();
  }
  return lines;
}

HelpFormatter::HelpFormatter()
{
  label("Positionals", "Arguments");
  label("SUBCOMMAND", "COMMAND");
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const
{
  std::string text = app->get_description() + "\n" + make_usage(app, std::move(name)) + make_positionals(app);
  for (const char* group : group::all) {
    const auto options = app->get_options(
        [group](const CLI::Option* option) { return option->get_group() == group && option->nonpositional(); });
    if (!options.empty())
      text += make_group(group, false, options);
  }
  return text + make_subcommands(app, mode) + "\n" + make_footer(app);
}

std::string HelpFormatter::make_option(const CLI::Option* option, bool is_positional) const
{
  return entryText(make_option_name(option, is_positional) + make_option_opts(option), make_option_desc(option), 30);
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const
{
  return entryText(command->get_name(), command->get_description(), 12);
}

} // namespace pcl_gpu_icp::cli
