#include "cli/options.h"

#include "cli/failure.h"
#include "cli/input_file.h"
#include "cli/number.h"

#include <cmath>
#include <map>

namespace pcl_gpu_icp::cli {
namespace {

constexpr std::string_view separators = " \t\r\n,";

CLI::Validator numberIn(const std::string& description, bool (*accepts)(double))
{
  return CLI::Validator(
      [description, accepts](std::string& text) {
        const auto value = parseNumber<double>(text);
        return value && std::isfinite(*value) && accepts(*value) ? "" : text + " is not " + description;
      },
      "");
}

CLI::Validator wholeNumber(int maximum)
{
  return CLI::Validator(
      [maximum](std::string& text) {
        const auto value = parseNumber<int>(text);
        return value && *value >= 1 && *value <= maximum
                   ? ""
                   : text + " is not a whole number from 1 to " + std::to_string(maximum);
      },
      "");
}

bool isNumber(const std::string& text)
{
  return parseNumber<double>(text).has_value();
}

} // namespace

CLI::Validator positiveNumber()
{
  return numberIn("a finite number above 0", [](double value) { return value > 0; });
}

void addAlignmentOptions(CLI::App& command, AlignmentOptions& options)
{
  command.add_option("SOURCE", options.source, "the cloud that is moved: .pcd or .ply")->required();
  command.add_option("TARGET", options.target, "the cloud it is moved onto: .pcd or .ply")->required();
  command.add_option("--guess", options.guess, "initial transform, 4x4 row by row: a file or 16 numbers")
      ->type_name("FILE|16 NUMBERS");
  command
      .add_option("--max-distance", options.max_distance, "ignore correspondences farther apart (default: no limit)")
      ->check(positiveNumber())
      ->type_name("DISTANCE");
  command.add_option("--iterations", options.iterations, "stop after so many iterations")
      ->check(wholeNumber(1000000))
      ->type_name("N")
      ->capture_default_str();
  command
      .add_option("--translation-epsilon",
                  options.translation_epsilon,
                  "converged when an iteration moves by no more than this and turns by no more than the rotation "
                  "epsilon; its square is PCL's setTransformationEpsilon (default: off)")
      ->check(positiveNumber())
      ->type_name("DISTANCE");
  command
      .add_option("--rotation-epsilon",
                  options.rotation_epsilon,
                  "see --translation-epsilon, which it needs; its cosine is PCL's setTransformationRotationEpsilon "
                  "(default: PCL's, the angle whose cosine is 1 - translation epsilon squared)")
      ->check(numberIn("a number of degrees above 0 and up to 180",
                       [](double value) { return value > 0 && value <= 180; }))
      ->needs("--translation-epsilon")
      ->type_name("DEGREES");
  command
      .add_option("--fitness-epsilon",
                  options.fitness_epsilon,
                  "converged when the mean squared distance changes by a smaller fraction than this: PCL's "
                  "setEuclideanFitnessEpsilon (default: off)")
      ->check(positiveNumber())
      ->type_name("FRACTION");
  command
      .add_option("--leaf",
                  options.leaf,
                  "align the centroids of a voxel grid of this size; files written keep every point")
      ->check(positiveNumber())
      ->type_name("SIZE");
  command.add_flag("--reciprocal", options.reciprocal, "keep only pairs that are each other's nearest");
  command.add_option("--trim", options.trim, "keep only this fraction of the pairs, the closest")
      ->check(numberIn("a fraction above 0 and up to 1", [](double value) { return value > 0 && value <= 1; }))
      ->type_name("FRACTION");
  command.add_flag("--drop-zero-returns",
                   options.drop_zero_returns,
                   "leave out points at exactly (0, 0, 0), which some sensors write where they saw nothing");
  command.add_option("--search", options.search, "what finds the correspondences: pcl (PCL's KD-tree on the host)")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, CorrespondenceSearch>{{"pcl", CorrespondenceSearch::PclKdTree}}))
      ->type_name("pcl")
      ->default_str("pcl");
  command.add_option("--pipeline", options.pipeline, "how the five stages run on the device")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, Pipeline>{{"staged", Pipeline::Staged}, {"fused", Pipeline::Fused}}))
      ->type_name("staged|fused")
      ->default_str("fused");
  command
      .add_option("--device",
                  options.device,
                  "gpu, accelerator, cpu, PLATFORM:DEVICE or part of a name; see the command devices (default: "
                  "PCL_GPU_ICP_DEVICE, or a GPU, accelerator or CPU, in this order)")
      ->type_name("DEVICE");
  command.add_option("--threads", options.threads, "host threads that search (default: all cores)")
      ->check(wholeNumber(1024))
      ->type_name("N");
  command.add_option("--json", options.json, "write the result as JSON; - is standard output, without the summary")
      ->type_name("FILE|-");
  command.add_flag("--force", options.force, "overwrite files that exist");
  command.add_flag("--quiet", options.quiet, "print nothing but errors");
}

std::vector<std::string> joinGuess(std::vector<std::string> arguments)
{
  const auto guess = std::find(arguments.begin(), arguments.end(), "--guess");
  if (guess == arguments.end())
    return arguments;
  const auto first = guess + 1;
  auto last = first;
  while (last != arguments.end() && last - first < 16 && isNumber(*last))
    ++last;
  if (last - first > 1) {
    for (auto number = first + 1; number != last; ++number)
      *first += " " + *number;
    arguments.erase(first + 1, last);
  }
  return arguments;
}

RigidTransform readGuess(const std::string& argument)
{
  if (argument.empty())
    return {};
  std::string text = argument;
  std::string_view words(text);
  const bool is_file = !parseNumber<double>(nextWord(words, separators));
  const std::string where = is_file ? "--guess " + argument : "--guess";
  const auto fail = [&](const std::string& why) {
    return Failure(is_file ? ExitCode::Input : ExitCode::Usage, where + ": " + why);
  };
  if (is_file)
    text = readFile(argument);

  std::vector<double> m;
  words = text;
  for (auto word = nextWord(words, separators); !word.empty(); word = nextWord(words, separators)) {
    const auto value = parseNumber<double>(word);
    if (!value || !std::isfinite(*value))
      throw fail(std::string(word.substr(0, 40)) + " is not a finite number");
    m.push_back(*value);
  }
  if (m.size() != 16)
    throw fail(std::to_string(m.size()) + " numbers where a 4x4 matrix has 16");

  constexpr double tolerance = 1e-3;
  RigidTransform guess;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      guess.rotation[3 * row + column] = m[4 * row + column];
    guess.translation[row] = m[4 * row + 3];
  }
  const auto& r = guess.rotation;
  bool rigid = m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double dot = r[3 * i] * r[3 * j] + r[3 * i + 1] * r[3 * j + 1] + r[3 * i + 2] * r[3 * j + 2];
      rigid = rigid && std::abs(dot - (i == j)) <= tolerance;
    }
  const double determinant = r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
                             r[2] * (r[3] * r[7] - r[4] * r[6]);
  if (!rigid || std::abs(determinant - 1) > 10 * tolerance)
    throw fail("not a rigid transform: rows of an orthonormal rotation (to 0.001, determinant +1) with the "
               "translation in the fourth column, then 0 0 0 1");
  return guess;
}

} // namespace pcl_gpu_icp::cli
