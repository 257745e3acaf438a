#include "cli/batch_files.h"
#include "cli/batch_ledger.h"
#include "cli/batch_progress.h"
#include "cli/commands.h"
#include "cli/guess.h"
#include "cli/help.h"
#include "cli/input_file.h"
#include "cli/interruption.h"
#include "cli/manifest.h"
#include "cli/number.h"
#include "cli/options.h"
#include "cli/pair_task.h"
#include "cli/point_count.h"
#include "cli/scan_sequence.h"
#include "cli/this_run.h"

#include "report/format.h"
#include "report/schedule_report.h"
#include "report/trajectory.h"
#include "view/batch_gallery.h"
#include "view/batch_page.h"

#include <pcl_gpu_icp/batch.h>
#include <pcl_gpu_icp/device.h>

#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>

namespace pcl_gpu_icp::cli {
namespace {

constexpr long most = std::numeric_limits<long>::max();

struct BatchOptions : AlignmentOptions {
  std::string manifest;
  std::string sequence;
  std::string directory;
  std::string trace;
  std::vector<std::string> devices;
  std::optional<report::Shard> shard;
  BatchSettings settings;
  bool resume = false;
  bool fail_fast = false;

  ResultsFile::Existing existing() const
  {
    using Existing = ResultsFile::Existing;
    return resume ? Existing::Continued : force ? Existing::Emptied : Existing::Refused;
  }
};

std::optional<report::Shard> shardOf(const std::string& text)
{
  const std::size_t slash = std::min(text.find('/'), text.size());
  const auto number = parseNumber<std::size_t>(std::string_view(text).substr(0, slash));
  const auto of = parseNumber<std::size_t>(std::string_view(text).substr(std::min(slash + 1, text.size())));
  if (!number || !of || *number < 1 || *number > *of)
    return std::nullopt;
  return report::Shard{*number, *of};
}

std::vector<ListedPair> listPairs(const BatchOptions& options, const OptionTexts& given)
{
  std::vector<ListedPair> pairs =
      options.sequence.empty() ? readManifest(options.manifest, given) : listSequence(options.sequence, given);
  if (options.shard)
    pairs.erase(std::remove_if(pairs.begin(),
                               pairs.end(),
                               [&](const ListedPair& pair) {
                                 return pair.identity.pair % options.shard->of != options.shard->number - 1;
                               }),
                pairs.end());
  for (ListedPair& pair : pairs)
    pair.alignment.threads = options.threads;
  return pairs;
}

std::vector<Device> selectDevices(const std::vector<std::string>& selectors)
{
  std::vector<Device> devices;
  for (const std::string& selector : selectors) {
    const Device device = Device::select(selector);
    for (const Device& other : devices)
      if (other.info().platform_index == device.info().platform_index &&
          other.info().device_index == device.info().device_index)
        throw Failure(ExitCode::Usage, "--device: " + device.info().name + " is chosen twice");
    devices.push_back(device);
  }
  if (devices.empty())
    devices.push_back(Device::select());
  return devices;
}

/// Of the files of many pairs, of which one may have many.
class PointCounts {
public:
  std::size_t of(const AlignmentOptions& pair) { return of(pair.source) + of(pair.target); }

private:
  std::size_t of(const std::string& file)
  {
    const auto [count, is_new] = counts_.try_emplace(file, 0);
    if (is_new)
      count->second = pointsInHeader(file);
    return count->second;
  }

  std::map<std::string, std::size_t> counts_;
};

/// One run over the pairs that have no result.
class Batch {
public:
  Batch(const BatchOptions& options, const std::vector<ListedPair>& pairs, std::vector<Device> devices)
  : options_(options)
  , pairs_(pairs)
  , devices_(std::move(devices))
  , files_(
        options.directory, options.shard, !options.sequence.empty(), options.trace, options.report, options.existing())
  , ledger_(pairs, files_.results->path(), files_.results->kept())
  , gallery_(pairs.size())
  , aligner_(devices_)
  {
    ledger_.describe(kept_);
    BatchSettings settings = options.settings;
    settings.keep_results = false;
    if (files_.trace)
      settings.schedule = schedule_;
    aligner_.setSettings(settings);
    PointCounts points;
    for (std::size_t place = 0; place < pairs.size(); ++place)
      if (!ledger_.has(place))
        places_.push_back(place);
    tasks_.reserve(places_.size());
    for (const std::size_t place : places_) {
      PairTask& task = tasks_.emplace_back(pairs[place], clouds_, files_.page ? gallery_.points() : 0);
      aligner_.add(points.of(pairs[place].alignment), [&task](DeviceLane& lane) { return task.run(lane); });
    }
    // It would tell of an earlier run if this one did not come to its end.
    std::filesystem::remove(files_.summary->location());
  }

  ExitCode run(const OptionTexts& given)
  {
    report::BatchReport report = align();
    if (report.left() > 0 && signal_ != 0)
      throw Failure(
          interruptedBy(signal_),
          report::format("interrupted with %zu of %zu pairs left; --resume goes on", report.left(), report.pairs));
    report.arguments = argumentsOfThisRun();
    report.options = given;
    write(report);
    if (!options_.quiet && warned_ > 0)
      print({report::format(
          "%zu of %zu pairs have warnings; see %s", warned_, report.aligned, files_.results->path().c_str())});
    if (!options_.quiet)
      writeToStandardOutput(report::toText(report));
    if (report.left() > 0 && !device_loss_.empty())
      throw Failure(ExitCode::Device,
                    device_loss_ +
                        report::format("; %zu of %zu pairs left; --resume goes on", report.left(), report.pairs));
    if (!report.unsuccessful.empty())
      throw Failure(
          ExitCode::NotConverged,
          report::format(
              "of %zu pairs %zu failed and %zu have no answer", report.pairs, report.failed(), report.notConverged()) +
              (report.left() > 0 ? report::format("; --fail-fast left %zu", report.left()) : "") + "; see " +
              files_.results->path());
    return ExitCode::Success;
  }

private:
  report::BatchReport align()
  {
    const std::size_t kept = kept_.pairs - kept_.left();
    BatchProgress progress(pairs_.size(), kept, kept_.unsuccessful.size(), options_.quiet);
    Interruption interruption([this](int /*signal*/) { aligner_.cancel(); });
    report::BatchReport report;
    {
      const auto begin = std::chrono::steady_clock::now();
      aligner_.run([&](std::size_t number, const BatchResult& result) { finish(number, result, progress); });
      report.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }
    signal_ = interruption.signal();
    ledger_.describe(report);
    report.kept = kept;
    report.aligned = progress.progress().aligned;
    return report;
  }

  void finish(std::size_t number, const BatchResult& result, BatchProgress& progress)
  {
    PairTask& task = tasks_[number];
    if (!task.isDone()) {
      if (result.alignment.reason == Reason::Error)
        device_loss_ = result.alignment.message;
      return;
    }
    files_.results->append(task.line());
    const report::PairOutcome outcome = task.outcome();
    if (outcome.warnings > 0)
      ++warned_;
    if (auto shown = task.takeShown())
      gallery_.add(std::move(*shown), outcome);
    task.clear();
    ledger_.add(places_[number], outcome);
    progress.add(task.pair().identity, outcome);
    if (options_.fail_fast && !isAnswer(outcome.status))
      aligner_.cancel();
  }

  void write(report::BatchReport& report)
  {
    report.shard = options_.shard;
    report.results = files_.results->path();
    for (const Device& device : devices_)
      report.devices.push_back(device.info());
    report.policy = options_.settings.policy;
    report.pairs_in_flight = options_.settings.lanes;
    report.points_in_flight = options_.settings.points_in_flight;
    report.capacity = options_.settings.capacity;
    std::vector<RigidTransform> places;
    if (files_.kitti)
      places = writeTrajectory(report);
    if (files_.trace)
      files_.trace->write(traceText());
    if (files_.page)
      files_.page->write(batchPage(report, readFile(files_.results->path()), gallery_, places, thisRun()));
    files_.summary->write(report::toJson(report));
    files_.commit();
  }

  /// \return the poses
  std::vector<RigidTransform> writeTrajectory(report::BatchReport& report)
  {
    report::Trajectory trajectory;
    report::TrajectoryReport& written = report.trajectory.emplace();
    for (const auto& outcome : ledger_.outcomes()) {
      if (!outcome || !isAnswer(outcome->status)) {
        written.ends_before_pair = trajectory.poses().size() - 1;
        break;
      }
      // Where the scanner stood is mapped as it was; the rotation, of 9 digits, would lose more with each scan.
      trajectory.add(nearestRigid(outcome->transform, {0, 0, 0}));
    }
    written.scans = pairs_.size() + 1;
    written.poses = trajectory.poses().size();
    written.files = {files_.kitti->path(), files_.tum->path()};
    files_.kitti->write(report::kittiText(trajectory));
    files_.tum->write(report::tumText(trajectory));
    return trajectory.poses();
  }

  std::string traceText() const
  {
    std::vector<report::TracedPair> traced;
    for (const std::size_t place : places_) {
      const report::PairIdentity& identity = pairs_[place].identity;
      traced.push_back({identity.pair, identity.source, identity.target});
    }
    std::vector<DeviceInfo> devices;
    for (const Device& device : devices_)
      devices.push_back(device.info());
    return report::toTrace(*schedule_, devices, traced);
  }

  const BatchOptions& options_;
  const std::vector<ListedPair>& pairs_;
  const std::vector<Device> devices_;
  BatchFiles files_;
  BatchLedger ledger_;
  report::BatchReport kept_; ///< what an earlier run came to
  const std::shared_ptr<Schedule> schedule_ = std::make_shared<Schedule>();
  std::vector<std::size_t> places_; ///< in the list, of the pairs that the aligner has
  view::BatchGallery gallery_;
  PreparedClouds clouds_;
  std::vector<PairTask> tasks_;
  BatchAligner aligner_;
  std::size_t warned_ = 0; ///< pairs of this run whose results have warnings
  int signal_ = 0;
  std::string device_loss_; ///< why pairs were left
};

ExitCode batch(const BatchOptions& options, const OptionTexts& given)
{
  if (options.manifest.empty() == options.sequence.empty())
    throw Failure(ExitCode::Usage, "batch takes either MANIFEST or --sequence (see --help)");
  const std::vector<ListedPair> pairs = [&] {
    const Interruption interruption(endAtOnce); // there is nothing yet that could be resumed
    return listPairs(options, given);
  }();
  return Batch(options, pairs, selectDevices(options.devices)).run(given);
}

/// Beside source and target.
std::string columnsText()
{
  std::string names;
  for (const std::string& name : PairOptions().names())
    names += (names.empty() ? "" : ", ") + name;
  return wrapped("A line of the manifest may have options of its own, in columns: " + names + ".", 0);
}

} // namespace

Run addBatch(CLI::App& command)
{
  const auto options = std::make_shared<BatchOptions>();
  command
      .add_option("MANIFEST",
                  options->manifest,
                  "the pairs: .csv whose header names the columns source, target and any of the options of a pair "
                  "(without dashes, see below), or .jsonl, an object with such keys in each line. The separator of "
                  ".csv may be a comma, a semicolon or a tab; lines that start with # are comments; a value keeps "
                  "blanks around it, or a # in front, where it is quoted. File names are relative to its folder")
      ->type_name("FILE");
  command
      .add_option("-o,--output",
                  options->directory,
                  "directory, made where there is none, for results.jsonl (a line for each pair, as it finishes) and "
                  "summary.json")
      ->required()
      ->type_name("DIR")
      ->group(group::common);
  addPairOptions(command, *options);
  command
      .add_option("--device",
                  options->devices,
                  "as align takes it; several, separated by commas or each with an option of its own, share the pairs")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name(device_type)
      ->group(group::common);
  const auto sequence =
      command
          .add_option("--sequence",
                      options->sequence,
                      "instead of a manifest: align each file that this pattern matches onto the one before, and write "
                      "the trajectory as trajectory.kitti.txt and trajectory.tum.txt")
          ->type_name("'PATTERN'")
          ->group(group::batch);
  const auto resume =
      command
          .add_flag("--resume",
                    options->resume,
                    "go on where an earlier run ended: keep the results that are whole, those of failed pairs too "
                    "(delete their lines to have them done again)")
          ->group(group::batch);
  command.add_flag("--fail-fast", options->fail_fast, "end at the first pair that fails or does not converge")
      ->group(group::batch);
  command
      .add_option_function<std::string>(
          "--shard",
          [options](const std::string& text) {
            options->shard = shardOf(text);
            if (!options->shard)
              throw CLI::ValidationError("--shard", text + " is not I/N with I from 1 to N");
          },
          "align only every Nth pair, from the Ith on; the files are results-I-of-N.jsonl and summary-I-of-N.json, and "
          "the results of all shards together those of the manifest")
      ->excludes(sequence)
      ->type_name("I/N")
      ->group(group::batch);
  command
      .add_option("--pairs-in-flight",
                  options->settings.lanes,
                  "pairs at once on each device (default: twice the cores, at most 8)")
      ->check(wholeNumber(1024))
      ->type_name("N")
      ->group(group::batch);
  command
      .add_option(
          "--report",
          options->report,
          "write a page of HTML, one file that a browser opens without a network: a table of the pairs, the worst "
          "first, and the clouds of as many as fit in")
      ->type_name("FILE")
      ->group(group::output);
  command
      .add_option("--trace", options->trace, "write what ran where and when, for ui.perfetto.dev or chrome://tracing")
      ->type_name("FILE")
      ->group(group::output);
  command.add_flag("--force", options->force, "overwrite results that exist")->excludes(resume)->group(group::output);
  command
      .add_flag("--quiet",
                options->quiet,
                "print nothing but errors: no summary, progress or word of warnings; the results have the warnings")
      ->group(group::output);
  command.add_option("--threads", options->threads, "host threads that search for each pair (default: 1)")
      ->check(wholeNumber(1024))
      ->type_name("N")
      ->group(group::advanced);
  command
      .add_option("--points-in-flight",
                  options->settings.points_in_flight,
                  "points of the pairs at once; a larger pair runs alone (default: no bound)")
      ->check(wholeNumber(most))
      ->type_name("N")
      ->group(group::advanced);
  command
      .add_option("--capacity",
                  options->settings.capacity,
                  "work-items that a device is given at once (default: as it reports)")
      ->check(wholeNumber(most))
      ->type_name("N")
      ->group(group::advanced);
  addChoice(
      command,
      "--policy",
      options->settings.policy,
      {{"smallest", Policy::SmallestFirst}, {"fifo", Policy::FirstComeFirstServed}, {"largest", Policy::LargestFirst}},
      "which request for work-items, and which pair, is next (default: smallest)")
      ->group(group::advanced);
  command.footer(columnsText() + "\n\n" +
                 exampleText({{"The pairs of a manifest, with a page of all results",
                               "pcl_gpu_icp batch pairs.csv -o results --report results.html"},
                              {"Go on after an interruption", "pcl_gpu_icp batch pairs.csv -o results --resume"},
                              {"The trajectory of a scanner from its scans",
                               "pcl_gpu_icp batch --sequence 'scan_*.pcd' -o trajectory --metric plane"}}));
  return [options, &command] { return batch(*options, PairOptions().givenTo(command)); };
}

} // namespace pcl_gpu_icp::cli
