#include "cli/options.h"

#include "cli/help.h"
#include "cli/input_file.h"
#include "cli/nearest_name.h"
#include "cli/number.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace pcl_gpu_icp::cli {
namespace {

constexpr LossFunction loss_functions[] = {LossFunction::None,
                                           LossFunction::Huber,
                                           LossFunction::Cauchy,
                                           LossFunction::GemanMcClure,
                                           LossFunction::Tukey,
                                           LossFunction::Welsch};

/// What docs/which-options.md recommends for a kind of data.
struct Preset {
  const char* name;
  Metric metric;
  LossFunction loss;
};
constexpr Preset presets[] = {{"lidar", Metric::Plane, LossFunction::Huber},
                              {"rgbd", Metric::Generalized, LossFunction::Huber},
                              {"object", Metric::Generalized, LossFunction::Huber}};

/// Sets what no option says otherwise.
void addPreset(CLI::App& command, AlignmentOptions& options)
{
  std::vector<std::string> names;
  std::string description = "what is recommended for data of a kind, but for what other options say:";
  const char* separator = " ";
  for (const auto& [name, metric, loss] : presets) {
    names.emplace_back(name);
    description += std::string(separator) + name + " is --metric " + toString(metric) + " --loss " + toString(loss);
    separator = ", ";
  }
  command.add_option("--preset", options.preset, description)
      ->check(CLI::Validator(
          [names](const std::string& text) {
            return std::find(names.begin(), names.end(), text) == names.end() ? noneOf(names, text) : "";
          },
          ""))
      ->type_name(CLI::detail::join(names, "|"))
      ->group(group::common);
  command.parse_complete_callback([&command, &options] {
    for (const auto& [name, metric, loss] : presets) {
      if (options.preset != name)
        continue;
      if (command.get_option("--metric")->count() == 0)
        options.metric = metric;
      if (!options.loss_is_given)
        options.loss = {loss};
    }
  });
}

std::vector<std::string> lossNames()
{
  std::vector<std::string> names;
  for (const LossFunction function : loss_functions)
    names.push_back(toString(function));
  return names;
}

/// NAME or NAME:SCALE.
Loss parseLoss(const std::string& text)
{
  const auto colon = text.find(':');
  const std::string name = text.substr(0, colon);
  for (const LossFunction function : loss_functions) {
    if (name != toString(function))
      continue;
    if (colon == std::string::npos)
      return {function};
    const auto scale = parseNumber<double>(text.substr(colon + 1));
    constexpr double least = 1e-18, most = 1e18; // of which float32 holds the squares
    if (function == LossFunction::None || !scale || !(*scale >= least && *scale <= most))
      throw CLI::ValidationError("--loss", text + " has no number from 1e-18 to 1e18 as its scale");
    return {function, *scale};
  }
  throw CLI::ValidationError("--loss", noneOf(lossNames(), name));
}

CLI::Validator numberIn(const std::string& description, bool (*accepts)(double))
{
  return CLI::Validator(
      [description, accepts](std::string& text) {
        const auto value = parseNumber<double>(text);
        return value && std::isfinite(*value) && accepts(*value) ? "" : text + " is not " + description;
      },
      "");
}

} // namespace

std::string noneOf(const std::vector<std::string>& names, const std::string& name)
{
  return name + " is not " + CLI::detail::join(names, "|") + didYouMean(name, names);
}

CLI::Validator positiveNumber()
{
  return numberIn("a finite number above 0", [](double value) { return value > 0; });
}

CLI::Validator wholeNumber(long maximum)
{
  return CLI::Validator(
      [maximum](std::string& text) {
        const auto value = parseNumber<long>(text);
        return value && *value >= 1 && *value <= maximum
                   ? ""
                   : text + " is not a whole number from 1 to " + std::to_string(maximum);
      },
      "");
}

void addPairOptions(CLI::App& command, AlignmentOptions& options)
{
  command
      .add_option("--guess",
                  options.guess,
                  "initial transform: a 4x4 matrix or its first three rows, row by row, or x y z qx qy qz qw; a file "
                  "or the numbers; or auto, to search for it")
      ->type_name("FILE|NUMBERS|auto")
      ->group(group::common);
  command
      .add_option("--max-distance", options.max_distance, "ignore correspondences farther apart (default: no limit)")
      ->check(positiveNumber())
      ->type_name("DISTANCE")
      ->group(group::common);
  command
      .add_option(
          "--leaf", options.leaf, "align the centroids of a voxel grid of this size; files written keep every point")
      ->check(positiveNumber())
      ->type_name("SIZE")
      ->group(group::common);
  addPreset(command, options);
  addChoice(
      command,
      "--metric",
      options.metric,
      {{"point", Metric::Point},
       {"plane", Metric::Plane},
       {"symmetric", Metric::Symmetric},
       {"gicp", Metric::Generalized}},
      "what is made small: point, the distances between points (the default); plane, those to the planes through the "
      "target's points, whose normals are estimated from the 20 nearest; symmetric, those along the mean of both "
      "points' normals; or gicp, both clouds' surfaces against each other (Generalized ICP): fewer iterations, on "
      "another path")
      ->group(group::matching);
  addChoice(command,
            "--search",
            options.search,
            {{"pcl", CorrespondenceSearch::PclKdTree}, {"device", CorrespondenceSearch::DeviceKdTree}},
            "what finds the correspondences: device, a tree on the device, which then does the whole iteration (the "
            "default), or pcl, which is PCL's KD-tree on the host")
      ->group(group::matching);
  addChoice(command,
            "--motions",
            options.motions,
            {{toString(Motions::Rigid), Motions::Rigid},
             {toString(Motions::Planar), Motions::Planar},
             {toString(Motions::Yaw), Motions::Yaw},
             {toString(Motions::Translation), Motions::Translation}},
            "how the source may move from the guess, in the target's frame: rigid, all six ways (the default); planar, "
            "along x and y and about z; yaw, along x, y and z and about z; or translation, without a turn")
      ->group(group::matching);
  command
      .add_option_function<std::string>(
          "--overlap",
          [&options](const std::string& text) { options.finds_overlap = text == "auto"; },
          "auto: for clouds that overlap in part, nobody knows how much: brings what they have in common onto each "
          "other, coarse to fine, and goes on from there with a loss, --loss or geman-mcclure of one spacing of the "
          "points (default: where the alignment comes to no good pose without)")
      ->check(CLI::Validator([](const std::string& text) { return text == "auto" ? "" : text + " is not auto"; }, ""))
      ->type_name("auto")
      ->group(group::robustness);
  command
      .add_option_function<std::string>(
          "--loss",
          [&options](const std::string& text) {
            options.loss = parseLoss(text);
            options.loss_is_given = true;
          },
          "make pairs that are far apart pull less, with a scale (a distance; for gicp a number) as in cauchy:0.1; "
          "without one it follows from the median of each iteration's residuals (default: none)")
      ->type_name(CLI::detail::join(lossNames(), "|") + "[:SCALE]")
      ->group(group::robustness);
  command.add_option("--trim", options.trim, "keep only this fraction of the pairs, the closest")
      ->check(numberIn("a fraction above 0 and up to 1", [](double value) { return value > 0 && value <= 1; }))
      ->type_name("FRACTION")
      ->group(group::robustness);
  command.add_flag("--reciprocal", options.reciprocal, "keep only pairs that are each other's nearest")
      ->group(group::robustness);
  command
      .add_flag_function(
          "--drop-zero-returns",
          [&options](std::int64_t count) { options.drop_zero_returns = count > 0; },
          "leave out points at exactly (0, 0, 0), which some sensors write where they saw nothing (default: where they "
          "are one in a hundred or more); --drop-zero-returns=false keeps them")
      ->group(group::robustness);
  addChoice(
      command,
      "--degenerate",
      options.undetermined,
      {{"fail", Undetermined::Fail}, {"solve", Undetermined::Solve}, {"keep", Undetermined::Keep}},
      "where the pairs leave motions undetermined, such as along a corridor: fail, no answer (the default); solve, "
      "take what noise makes of them; or keep, leave those motions as the guess has them")
      ->group(group::robustness);
  command
      .add_flag("--once",
                options.once,
                "align once: a pose that is not good is not tried to be bettered as by --overlap auto, nor one that is "
                "wrong or far from its start, where no --guess is given, as by --guess auto")
      ->group(group::robustness);
  command.add_flag("--strict", options.strict, "take no answer but one whose verdict is good")
      ->group(group::robustness);
  command.add_option("--iterations", options.iterations, "stop after so many iterations")
      ->check(wholeNumber(1000000))
      ->type_name("N")
      ->capture_default_str()
      ->group(group::ending);
  command
      .add_option("--translation-epsilon",
                  options.translation_epsilon,
                  "converged when an iteration moves the cloud by no more than this, and turns it by no more than the "
                  "rotation epsilon. PCL's setTransformationEpsilon takes its square (default: a thousandth of the "
                  "target's spacing, and of compare 0)")
      ->check(numberIn("a finite number from 0", [](double value) { return value >= 0; }))
      ->type_name("DISTANCE")
      ->group(group::ending);
  command
      .add_option("--rotation-epsilon",
                  options.rotation_epsilon,
                  "the angle that goes with --translation-epsilon. PCL's setTransformationRotationEpsilon takes its "
                  "cosine (default: what moves a point at the source's radius as far as that default; with a "
                  "translation epsilon PCL's, whose cosine is 1 - translation epsilon squared)")
      ->check(
          numberIn("a number of degrees above 0 and up to 180", [](double value) { return value > 0 && value <= 180; }))
      ->type_name("DEGREES")
      ->group(group::ending);
  command
      .add_option("--fitness-epsilon",
                  options.fitness_epsilon,
                  "converged when the mean squared distance changes by a smaller fraction than this: PCL's "
                  "setEuclideanFitnessEpsilon (default: off)")
      ->check(positiveNumber())
      ->type_name("FRACTION")
      ->group(group::ending);
  command
      .add_flag("--anderson",
                options.anderson,
                "extrapolate from the last iterations (Anderson acceleration): fewer iterations, on another path")
      ->group(group::advanced);
  addChoice(command,
            "--pipeline",
            options.pipeline,
            {{"staged", Pipeline::Staged}, {"fused", Pipeline::Fused}},
            "how the five stages run on the device (default: fused)")
      ->group(group::advanced);
}

void addAlignmentOptions(CLI::App& command, AlignmentOptions& options)
{
  command
      .add_option("SOURCE",
                  options.source,
                  "the cloud that is moved: .pcd, .ply, .las, a text of points (.xyz, .csv, .pts, ...), KITTI's .bin "
                  "or .vtk; - reads standard input")
      ->required()
      ->type_name("FILE");
  command.add_option("TARGET", options.target, "the cloud it is moved onto, as SOURCE")
      ->required()
      ->check(CLI::Validator(
          [&options](std::string& target) {
            return target == standard_input && options.source == standard_input
                       ? "SOURCE is standard input already, and it can be read once"
                       : "";
          },
          ""))
      ->type_name("FILE");
  addPairOptions(command, options);
  command
      .add_option("--device",
                  options.device,
                  "a kind of device, PLATFORM:DEVICE or part of a name; see the command devices (default: "
                  "PCL_GPU_ICP_DEVICE, or a GPU, accelerator or CPU, in this order)")
      ->type_name(device_type)
      ->group(group::common);
  command.add_option("--threads", options.threads, "host threads that search (default: all cores)")
      ->check(wholeNumber(1024))
      ->type_name("N")
      ->group(group::advanced);
  command.add_option("--json", options.json, "write the result as JSON; - is standard output, without the summary")
      ->type_name("FILE|-")
      ->group(group::output);
  command
      .add_option(
          "--report",
          options.report,
          "write a page of HTML, one file that a browser opens without a network: the clouds before and after in "
          "3-D, distances, iterations, times; also where there is no answer")
      ->type_name("FILE")
      ->group(group::output);
  command.add_flag("--force", options.force, "overwrite files that exist")->group(group::output);
  command
      .add_flag("--quiet",
                options.quiet,
                "print nothing but errors: no summary, progress or warnings; the JSON has the warnings")
      ->group(group::output);
}

} // namespace pcl_gpu_icp::cli
