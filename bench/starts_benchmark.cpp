// What the command finds without options, and with --once, on pairs of known answers: how often it is right, what it
// says of that, and how long it takes, as a table.
#include "../test/command/started_pair.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <map>

using namespace pcl_gpu_icp;

namespace {

struct Counts {
  int pairs = 0, right_at_once = 0, right = 0, right_and_good = 0, right_with_rival = 0, off_and_good = 0;
  double ms_at_once = 0, ms = 0;
};

void printRow(const std::string& kind, const Counts& counts)
{
  std::printf("| %s | %d | %d | %d | %d | %d | %d | %.0f ms | %.0f ms |\n",
              kind.c_str(),
              counts.pairs,
              counts.right_at_once,
              counts.right,
              counts.right_and_good,
              counts.right_with_rival,
              counts.off_and_good,
              counts.ms_at_once / counts.pairs,
              counts.ms / counts.pairs);
}

} // namespace

int main(int argc, char** argv)
{
  std::string scans = "../shared/data", csv;
  int repetitions = 8;
  unsigned seed = 9;
  bool far = false;
  cli::AlignmentOptions options;
  CLI::App app{"What the command finds without options on pairs of known answers"};
  app.add_option("--scans", scans, "the folder of the scans")->capture_default_str();
  app.add_option("--repetitions", repetitions, "of every kind of pair")->capture_default_str();
  app.add_option("--seed", seed, "of the pairs")->capture_default_str();
  app.add_flag("--far", far, "from guesses anywhere; else up to 30 degrees and a tenth of the extent off");
  app.add_option("--csv", csv, "writes a line for each pair");
  cli::addPairOptions(app, options);
  CLI11_PARSE(app, argc, argv);
  std::FILE* const lines = csv.empty() ? nullptr : std::fopen(csv.c_str(), "w");
  if (!csv.empty() && !lines)
    return std::fprintf(stderr, "cannot write %s\n", csv.c_str()), 1;
  if (lines)
    std::fprintf(lines, "kind,clouds,off,verdict,rival,near,starts,ms\n");

  std::map<std::string, Counts> kinds;
  Counts all;
  for (const made_pairs::Pair& pair : far ? made_pairs::makeFarPairs(scans, repetitions, seed)
                                          : made_pairs::makeNearbyPairs(scans, repetitions, seed)) {
    cli::AlignmentOptions once = options;
    once.once = true;
    const made_pairs::StartedPair at_once = made_pairs::started(pair, once), found = made_pairs::started(pair, options);
    const bool is_good = found.verdict() == Verdict::Good;
    const bool has_rival = isDoubtedForRivalAlone(found.report);
    for (Counts* counts : {&kinds[pair.kind], &all}) {
      ++counts->pairs;
      counts->right_at_once += at_once.isRight() ? 1 : 0;
      counts->right += found.isRight() ? 1 : 0;
      counts->right_and_good += found.isRight() && is_good ? 1 : 0;
      counts->right_with_rival += found.isRight() && has_rival ? 1 : 0;
      counts->off_and_good += !found.isRight() && is_good ? 1 : 0;
      counts->ms_at_once += at_once.milliseconds;
      counts->ms += found.milliseconds;
    }
    if (!lines)
      continue;
    std::string starts;
    for (const report::TriedStart& start : found.report.tried)
      starts += (starts.empty() ? "" : "; ") + report::nameOf(start) + ": " + toString(start.verdict) +
                (start.taken ? " (taken)" : "");
    std::fprintf(lines,
                 "%s,%s,%.3g,%s,%d,%.3g,%s,%.0f\n",
                 pair.kind.c_str(),
                 pair.clouds.c_str(),
                 found.off,
                 toString(found.verdict()),
                 has_rival ? 1 : 0,
                 found.report.result.quality ? found.report.result.quality->after.source : 0,
                 starts.c_str(),
                 found.milliseconds);
  }
  if (lines && std::fclose(lines) != 0)
    return std::fprintf(stderr, "cannot write %s\n", csv.c_str()), 1;
  std::printf("| | pairs | right with --once | right | and good | doubtful for another pose alone | off and good | "
              "mean time with --once | mean time |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& [kind, counts] : kinds)
    printRow(kind, counts);
  printRow("all", all);
  return 0;
}
