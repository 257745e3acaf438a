#include "cli/pair_options.h"

#include "cli/failure.h"
#include "cli/guess.h"
#include "cli/lower_case.h"
#include "cli/number.h"

#include "report/format.h"

namespace pcl_gpu_icp::cli {
namespace {

bool isFlag(const CLI::Option& option) { return option.get_expected_max() == 0; }

std::string nameOf(const CLI::Option& option) { return option.get_lnames().empty() ? "" : option.get_lnames().front(); }

/// Numbers in one spelling; any other text as it is.
std::string canonical(const std::string& text)
{
  std::string numbers;
  std::string_view words(text);
  for (auto word = nextWord(words, number_separators); !word.empty(); word = nextWord(words, number_separators)) {
    const auto value = parseNumber<double>(word);
    if (!value)
      return text;
    char shortest[32];
    const auto [end, error] = std::to_chars(std::begin(shortest), std::end(shortest), *value);
    numbers += (numbers.empty() ? "" : " ") + std::string(shortest, end);
  }
  return numbers;
}

} // namespace

PairOptions::PairOptions()
{
  app_.set_help_flag();
  addPairOptions(app_, options_);
}

bool PairOptions::has(const std::string& name) const { return app_.get_option_no_throw("--" + name) != nullptr; }

std::vector<std::string> PairOptions::names() const
{
  std::vector<std::string> names;
  for (const CLI::Option* option : app_.get_options())
    names.push_back(nameOf(*option));
  return names;
}

OptionTexts PairOptions::givenTo(const CLI::App& command) const
{
  OptionTexts given;
  for (const CLI::Option* option : command.get_options())
    if (option->count() > 0 && has(nameOf(*option)))
      given[nameOf(*option)] = canonical(option->results().back());
  return given;
}

std::string PairOptions::checked(const std::string& name, const std::string& text)
{
  const CLI::Option* option = app_.get_option_no_throw("--" + name);
  if (!option)
    throw std::invalid_argument("there is no option " + name + " for a pair");
  std::string result = isFlag(*option) ? lowerCase(text) : canonical(text);
  if (isFlag(*option) && result != "true" && result != "false")
    throw std::invalid_argument(name + ": " + text + " is not true or false");
  try {
    const AlignmentOptions options = parse({{name, result}});
    if (options.guess && !asksForSearch(*options.guess) &&
        !namesFile(*options.guess)) // a file is read when its turn comes
      readGuess(*options.guess);
  } catch (const CLI::ParseError& error) {
    const std::string what = error.what();
    throw std::invalid_argument(what.rfind("--", 0) == 0 ? what.substr(2) : what);
  } catch (const Failure& failure) {
    const std::string what = failure.what();
    throw std::invalid_argument(what.rfind("--", 0) == 0 ? what.substr(2) : what);
  }
  return result;
}

AlignmentOptions PairOptions::parse(const OptionTexts& texts)
{
  std::vector<std::string> arguments;
  for (const auto& [name, text] : texts)
    arguments.push_back(std::string("--").append(name).append("=").append(text));
  options_ = AlignmentOptions();
  app_.parse(arguments); // takes them from the end, and their order means nothing
  return options_;
}

} // namespace pcl_gpu_icp::cli
