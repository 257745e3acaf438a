#pragma once

#include <pcl_gpu_icp/result.h>

#include <CLI/CLI.hpp>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pcl_gpu_icp::cli {

/// What becomes of motions that the pairs do not determine.
enum class Undetermined { Fail, Solve, Keep };

/// What the commands that align have in common. An unset value leaves PCL's default.
struct AlignmentOptions {
  std::string source;
  std::string target;
  std::optional<std::string> guess; ///< a file name or numbers
  std::optional<double> max_distance;
  int iterations = 100;
  std::optional<double> translation_epsilon; ///< a distance; 0: none
  std::optional<double> rotation_epsilon;    ///< degrees
  std::optional<double> fitness_epsilon;
  std::optional<double> leaf;
  bool anderson = false;
  bool reciprocal = false;
  std::optional<double> trim;
  std::optional<bool> drop_zero_returns; ///< unset: where they are many
  std::string preset;                    ///< a name; what it sets is in the members
  Metric metric = Metric::Point;
  Loss loss;
  bool loss_is_given = false; ///< by --loss, and not a preset's or none
  Motions motions = Motions::Rigid;
  Undetermined undetermined = Undetermined::Fail;
  bool strict = false;
  bool finds_overlap = false; ///< --overlap auto
  bool once = false;          ///< no other start is tried
  CorrespondenceSearch search = CorrespondenceSearch::DeviceKdTree;
  Pipeline pipeline = Pipeline::Fused;
  std::string device;
  unsigned threads = 0;
  std::string json;   ///< a file name, or "-" for standard output
  std::string report; ///< a file name
  bool force = false;
  bool quiet = false;
};

/// All of them, of a command for one pair.
void addAlignmentOptions(CLI::App& command, AlignmentOptions& options);

/// Those that decide what an alignment of two files comes to.
void addPairOptions(CLI::App& command, AlignmentOptions& options);

/// A finite number above zero, for arguments.
CLI::Validator positiveNumber();

/// A whole number from 1 to `maximum`.
CLI::Validator wholeNumber(long maximum);

/// The type of an option that takes what Device::select() does.
inline constexpr const char* device_type = "gpu|accelerator|cpu|DEVICE";

/// What is wrong with a name that is none of these.
std::string noneOf(const std::vector<std::string>& names, const std::string& name);

/// An option that takes one of the names given.
template <typename Value>
CLI::Option* addChoice(CLI::App& command,
                       const std::string& option,
                       Value& value,
                       const std::map<std::string, Value>& choices,
                       const std::string& description)
{
  std::vector<std::string> names;
  for (const auto& choice : choices)
    names.push_back(choice.first);
  const auto choose = [&value, option, choices, names](const std::string& name) {
    const auto choice = choices.find(name);
    if (choice == choices.end())
      throw CLI::ValidationError(option, noneOf(names, name));
    value = choice->second;
  };
  return command.add_option_function<std::string>(option, choose, description)
      ->type_name(CLI::detail::join(names, "|"));
}

} // namespace pcl_gpu_icp::cli
