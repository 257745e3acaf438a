#pragma once

#include <CLI/CLI.hpp>

#include <initializer_list>
#include <string>

namespace pcl_gpu_icp::cli {

/// Groups of options, in the order in which help and manual page have them.
namespace group {
inline constexpr const char* common = "Common options";
inline constexpr const char* matching = "Search and metric";
inline constexpr const char* robustness = "Robustness";
inline constexpr const char* ending = "When it ends";
inline constexpr const char* output = "Output";
inline constexpr const char* batch = "Batch";
inline constexpr const char* comparison = "Comparison";
inline constexpr const char* advanced = "Advanced";
inline constexpr const char* all[] = {common, matching, robustness, ending, output, batch, comparison, advanced};
} // namespace group

struct Example {
  const char* purpose;
  const char* line;
};

/// The end of a command's help.
std::string exampleText(std::initializer_list<Example> examples);

/// Broken at blanks into lines of a help that is 80 columns wide; the first begins at `column` already, the others with
/// as many blanks.
std::string wrapped(const std::string& text, std::size_t column);

/// Help by groups, in lines that fit a terminal.
class HelpFormatter : public CLI::Formatter {
public:
  HelpFormatter();
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
  std::string make_subcommand(const CLI::App* command) const override;
};

} // namespace pcl_gpu_icp::cli
