#include "cli/completion.h"

#include "cli/command_names.h"
#include "cli/option_values.h"

namespace pcl_gpu_icp::cli {
namespace {

std::string joined(const std::vector<std::string>& words, const char* between = " ")
{
  return CLI::detail::join(words, between);
}

bool takesFiles(const CLI::App& command)
{
  return !command.get_options([](const CLI::Option* option) { return option->get_positional(); }).empty();
}

/// compgen's arguments.
std::string bashAction(const OptionValues& values)
{
  return std::string(values.files ? " -f" : "") + (values.directories ? " -d" : "") +
         (values.words.empty() ? "" : " -W '" + joined(values.words) + "'");
}

std::string bashCommand(const CLI::App& command)
{
  const std::string& name = command.get_name();
  std::string cases;
  for (const CLI::Option* option : command.get_options()) {
    const OptionValues values = valuesOf(*option);
    if (option->get_positional() || !values.any)
      continue;
    std::string patterns;
    for (const std::string& spelled : namesOf(*option))
      patterns += (patterns.empty() ? "'" : " | '") + name + " " + spelled + "'";
    const std::string action = bashAction(values);
    cases += "  " + patterns + ") " + (action.empty() ? "return" : "_pcl_gpu_icp_reply" + action) + " ;;\n";
  }
  cases += "  '" + name + " '*)\n    if [[ $current == -* ]]; then _pcl_gpu_icp_reply -W '" +
           joined(optionsOf(command)) + "'" + (takesFiles(command) ? "; else _pcl_gpu_icp_reply -f" : "") + "; fi ;;\n";
  return cases;
}

/// As _arguments takes it within single quotes.
std::string zshText(const std::string& text)
{
  std::string quoted;
  for (const char c : text)
    if (c == '\'')
      quoted += "'\\''";
    else
      quoted += (c == '[' || c == ']' || c == ':' || c == '\\' ? "\\" : "") + std::string(1, c);
  return quoted;
}

std::string zshAction(const OptionValues& values)
{
  const std::string files = values.files ? "_files" : values.directories ? "_files -/" : "";
  const std::string words = values.words.empty() ? "" : "(" + joined(values.words) + ")";
  if (files.empty() || words.empty())
    return files + words;
  return R"({_alternative "files\:file\:)" + files + R"(" "words\:word\:)" + words + "\"}";
}

std::string zshOption(const CLI::Option& option)
{
  const OptionValues values = valuesOf(option);
  const std::string value = values.any ? ":" + zshText(option.get_type_name()) + ":" + zshAction(values) : "";
  const bool repeats = option.get_expected_max() > 1;
  const auto names = namesOf(option);
  std::string lines;
  for (const std::string& name : names)
    lines += " \\\n      '" + (repeats ? "*" : "(" + joined(names) + ")") + name +
             (values.any && name.rfind("--", 0) == 0 ? "=" : "") + "[" + zshText(option.get_description()) + "]" +
             value + "'";
  return lines;
}

std::string zshArguments(const CLI::App& command)
{
  std::string lines;
  int place = 0;
  for (const CLI::Option* option : command.get_options())
    lines += option->get_positional() ? " \\\n      '" + std::to_string(++place) + ":" +
                                            zshText(option->get_name(true)) + ":" + zshAction(valuesOf(*option)) + "'"
                                      : zshOption(*option);
  return lines + "\n";
}

} // namespace

std::string bashCompletion(const CLI::App& app)
{
  std::string text = R"(# bash completion for pcl_gpu_icp

_pcl_gpu_icp_reply()
{
  [[ $1 == -[fd] ]] && compopt -o filenames 2> /dev/null
  mapfile -t COMPREPLY < <(compgen "$@" -- "$current")
}

_pcl_gpu_icp()
{
  local current=${COMP_WORDS[COMP_CWORD]} option=${COMP_WORDS[COMP_CWORD-1]} command=
  # Of --option=value readline makes three words.
  if [[ $current == = ]]; then
    current=
  elif [[ $option == = ]]; then
    option=${COMP_WORDS[COMP_CWORD-2]}
  fi
  ((COMP_CWORD > 1)) && command=${COMP_WORDS[1]}
  COMPREPLY=()
  case "$command $option" in
)";
  for (const CLI::App* command : app.get_subcommands({}))
    text += bashCommand(*command);
  text += "  ' '*) _pcl_gpu_icp_reply -W '" + joined(commandsOf(app)) + " " + joined(optionsOf(app)) + "' ;;\n";
  return text + R"(  esac
}
complete -F _pcl_gpu_icp pcl_gpu_icp
)";
}

std::string zshCompletion(const CLI::App& app)
{
  std::string text = R"(#compdef pcl_gpu_icp

local context state line
typeset -A opt_args
_arguments -C \
      '1:command:->command' \
      '*::argument:->argument')" +
                     zshArguments(app) + R"(case $state in
command)
  local -a commands=()";
  for (const CLI::App* command : app.get_subcommands({}))
    text += "\n    '" + command->get_name() + ":" + zshText(command->get_description()) + "'";
  text += ")\n  _describe command commands ;;\nargument)\n  case $line[1] in\n";
  for (const CLI::App* command : app.get_subcommands({}))
    text += "  " + command->get_name() + ")\n    _arguments" + zshArguments(*command) + "    ;;\n";
  return text + "  esac ;;\nesac\n";
}

} // namespace pcl_gpu_icp::cli
