#include "cli/aligned_cloud.h"
#include "cli/cloud_file.h"
#include "cli/cloud_pair.h"
#include "cli/coloured_cloud.h"
#include "cli/commands.h"
#include "cli/compilation_notice.h"
#include "cli/help.h"
#include "cli/icp_settings.h"
#include "cli/interruption.h"
#include "cli/live_line.h"
#include "cli/options.h"
#include "cli/output_file.h"
#include "cli/pair_alignment.h"
#include "cli/shown_pair.h"
#include "cli/this_run.h"

#include "report/ending.h"
#include "report/format.h"
#include "report/matrix.h"
#include "view/colours.h"
#include "view/pair_page.h"
#include "view/picture.h"
#include "view/text.h"

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/stopwatch.h>

#include <limits>
#include <memory>
#include <optional>

namespace pcl_gpu_icp::cli {
namespace {

using Icp = pcl_gpu_icp::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ, double>;

struct AlignOptions : AlignmentOptions {
  std::string output;
  std::string both;
  std::string matrix;
  std::string png;
  bool verbose = false;
};

/// The files to write; null where none was asked for.
struct Outputs {
  std::unique_ptr<OutputFile> cloud;
  std::unique_ptr<OutputFile> both;
  std::unique_ptr<OutputFile> matrix;
  std::unique_ptr<OutputFile> json;
  std::unique_ptr<OutputFile> png;
  std::unique_ptr<OutputFile> page;

  std::vector<OutputFile*> all() const
  {
    return {cloud.get(), both.get(), matrix.get(), json.get(), png.get(), page.get()};
  }
};

Outputs openOutputs(const AlignOptions& options)
{
  const auto open = [&options](const char* option, const std::string& path) {
    return path.empty() ? nullptr : std::make_unique<OutputFile>(option, path, options.force);
  };
  Outputs outputs{open("-o", options.output),
                  open("--both", options.both),
                  open("--matrix", options.matrix),
                  open("--json", options.json == "-" ? "" : options.json),
                  open("--png", options.png),
                  open("--report", options.report)};
  requireDistinct(outputs.all());
  return outputs;
}

/// The clouds as their files have them.
struct Files {
  std::optional<Cloud> source;
  std::optional<Cloud> target; ///< none where nothing of it is written
};

CloudPair timedRead(StageTimes& times, const AlignOptions& options, Files& files, LiveLine& line)
{
  const Stopwatch watch(times, "read");
  return readPair(options, [&](const std::string& path) {
    line.show("reading " + view::fileNameOf(path));
    const bool is_target = files.source.has_value();
    if (is_target && options.both.empty())
      return std::make_shared<const PreparedCloud>(prepare(readCloudArgument(path), path, options));
    const Cloud& file = (is_target ? files.target : files.source).emplace(readCloudArgument(path));
    return std::make_shared<const PreparedCloud>(prepare(file, path, options));
  });
}

Device timedSelect(StageTimes& times, const AlignOptions& options)
{
  const Stopwatch watch(times, "device");
  return Device::select(options.device);
}

std::optional<double> timedFitness(StageTimes& times, Icp& icp)
{
  const Stopwatch watch(times, "fitness");
  const double fitness = icp.getFitnessScore();
  return fitness < std::numeric_limits<double>::max() ? std::optional(fitness) : std::nullopt;
}

/// Shows how far it is.
IcpRun
runIcp(const CloudPair& pair, const AlignmentOptions& options, const Device& device, LiveLine& line, StageTimes& times)
{
  Icp icp;
  setUp(icp, pair, options, device);
  IcpRun run;
  icp.setIterationCallback([&](int iteration, double rmse, std::size_t searched) {
    run.errors.push_back(rmse);
    line.show(report::format("iteration %d  RMSE %.6g  searched %zu points", iteration, rmse, searched));
  });
  icp.alignWithoutOutput(detail::toMatrix<double>(pair.guess));
  run.result.alignment = icp.getResult();
  requireNoError(run.result.alignment);
  run.result.transform = detail::toRigidTransform<double>(icp.getFinalTransformation());
  run.result.fitness_score = timedFitness(times, icp);
  return run;
}

void writeResults(Outputs& outputs,
                  const Files& files,
                  const report::AlignmentReport& report,
                  const AlignOptions& options)
{
  if (isAnswer(endingOf(report))) {
    if (outputs.cloud) {
      Cloud moved = *files.source;
      transform(moved, report.transform, report.source_points.zero_returns > 0);
      outputs.cloud->write(writeCloud(moved, *formatOf(options.output)));
    }
    if (outputs.both) {
      const std::vector<ColouredPart> parts{
          {*files.source, options.source, report.transform, report.source_points.zero_returns > 0, view::source_colour},
          {*files.target,
           options.target,
           RigidTransform(),
           report.target_points.zero_returns > 0,
           view::target_colour}};
      outputs.both->write(writeCloud(colouredCloud(parts, options.both), *formatOf(options.both)));
    }
    if (outputs.matrix)
      outputs.matrix->write(report::matrixFile(report.transform));
  }
  else {
    outputs.cloud.reset();
    outputs.both.reset();
    outputs.matrix.reset();
  }
  if (outputs.json)
    outputs.json->write(report::toJson(report));
}

void drawResults(Outputs& outputs,
                 const report::AlignmentReport& report,
                 const view::PairView& view,
                 const std::vector<double>& errors)
{
  if (outputs.png)
    outputs.png->write(pictureOf(report, view));
  if (outputs.page)
    outputs.page->write(alignmentPage(report, view, errors, thisRun()));
}

ExitCode align(const AlignOptions& options)
{
  Outputs outputs = openOutputs(options);
  StageTimes times;
  std::optional<Stopwatch> total(std::in_place, times, "total");
  Files files;
  LiveLine line(!options.quiet);
  const CloudPair pair = timedRead(times, options, files, line);
  line.clear();
  if (!options.quiet)
    print(pair.warnings);
  const Warnings left_out = outputs.cloud ? checkWritable(*files.source, options.output) : Warnings();
  if (!options.quiet)
    print(left_out);
  const Device device = timedSelect(times, options);
  std::optional<CompilationNotice> notice(std::in_place, line, !options.quiet);
  const StartSearch search(device, nullptr, times, [&line](std::size_t done, std::size_t all) {
    line.show(report::format("searching for a guess: %zu of %zu groups of starts", done, all));
  });
  auto [report, errors] = alignPair(pair, options, search, [&](const CloudPair& from, const AlignmentOptions& with) {
    return runIcp(from, with, device, line, times);
  });
  total.reset();
  notice.reset();
  line.clear();
  report.arguments = argumentsOfThisRun();
  report.command_times = times;
  append(report.warnings, left_out);
  const bool lacks_outputs = !isAnswer(endingOf(report)) && (outputs.cloud || outputs.both || outputs.matrix);
  writeResults(outputs, files, report, options);
  if (outputs.png || outputs.page)
    drawResults(outputs, report, shownPair(pair, posesOf(report, pair)), errors);
  OutputFile::commit(outputs.all());
  if (options.json == "-")
    writeToStandardOutput(report::toJson(report));
  else if (!options.quiet)
    writeToStandardOutput(report::toText(report, {options.verbose, isColoured(STDOUT_FILENO)}));
  if (!isAnswer(endingOf(report)))
    throw Failure(ExitCode::NotConverged,
                  options.source + " onto " + options.target + ": " + endingText(report) +
                      (lacks_outputs ? "; -o, --both and --matrix not written" : ""));
  return ExitCode::Success;
}

CLI::Validator cloudFile()
{
  return CLI::Validator([](std::string& path) { return formatOf(path) ? "" : path + " ends in neither .pcd nor .ply"; },
                        "");
}

} // namespace

Run addAlign(CLI::App& command)
{
  const auto options = std::make_shared<AlignOptions>();
  command.add_option("-o,--output", options->output, "write the source, moved, with all its fields: .pcd or .ply")
      ->check(cloudFile())
      ->type_name("FILE")
      ->group(group::common);
  addAlignmentOptions(command, *options);
  command
      .add_option("--both",
                  options->both,
                  "write the source, moved, and the target into one cloud, in two colours that everybody can tell "
                  "apart: .pcd or .ply")
      ->check(cloudFile())
      ->type_name("FILE")
      ->group(group::output);
  command.add_option("--matrix", options->matrix, "write the transform: 4 lines of 4 numbers")
      ->type_name("FILE")
      ->group(group::output);
  command
      .add_option("--png",
                  options->png,
                  "draw the clouds before and after from three sides, and the distances; also where there is no answer")
      ->type_name("FILE")
      ->group(group::output);
  command
      .add_flag(
          "--verbose", options->verbose, "every time that was taken in the summary, each below what it is a part of")
      ->group(group::output);
  command.footer(
      exampleText({{"Write the source, moved onto the target, and the transform",
                    "pcl_gpu_icp align source.pcd target.pcd -o aligned.pcd --matrix pose.txt"},
                   {"Surfaces, from a pose known to half a metre; look at the result in a browser",
                    "pcl_gpu_icp align source.ply target.ply --metric plane --max-distance 0.5 \\\n        "
                    "--guess pose.txt --report result.html"},
                   {"Large clouds in an unknown pose, for a script: JSON, good answers only",
                    "pcl_gpu_icp align source.pcd target.pcd --leaf 0.2 --guess auto \\\n        --strict --json -"}}));
  return [options] {
    const Interruption interruption(endAtOnce);
    return align(*options);
  };
}

} // namespace pcl_gpu_icp::cli
