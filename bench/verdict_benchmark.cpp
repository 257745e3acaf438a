// What judge() says of alignments whose answer is known, as a table.
#include "../test/pcl/judged_pair.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <map>

using namespace pcl_gpu_icp;

namespace {

struct Counts {
  int verdicts[2][3] = {}; ///< whether it is right, verdict
  void add(bool right, Verdict verdict) { ++verdicts[right ? 1 : 0][static_cast<int>(verdict)]; }
  int of(bool right) const { return verdicts[right][0] + verdicts[right][1] + verdicts[right][2]; }
};

void printRow(const std::string& what, const Counts& counts)
{
  std::printf("| %s |", what.c_str());
  for (const bool right : {true, false}) {
    std::printf(" %d |", counts.of(right));
    for (const int count : counts.verdicts[right])
      std::printf(" %d |", count);
  }
  std::printf("\n");
}

double median(std::vector<double> values)
{
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

} // namespace

int main(int argc, char** argv)
{
  std::string scans = "../shared/data", csv;
  int repetitions = 24;
  unsigned seed = 4;
  CLI::App app{"What the verdict says of alignments whose answer is known"};
  app.add_option("--scans", scans, "the folder of the scans")->capture_default_str();
  app.add_option("--repetitions", repetitions, "of every kind of pair")->capture_default_str();
  app.add_option("--seed", seed, "of the pairs: the limits were set on those of 1 and 2")->capture_default_str();
  app.add_option("--csv", csv, "writes a line for each alignment");
  CLI11_PARSE(app, argc, argv);
  std::FILE* const lines = csv.empty() ? nullptr : std::fopen(csv.c_str(), "w");
  if (!csv.empty() && !lines)
    return std::fprintf(stderr, "cannot write %s\n", csv.c_str()), 1;
  if (lines)
    std::fprintf(lines,
                 "kind,clouds,metric,related,off,points,source_near,target_near,median,concentration,share,alike,"
                 "distance,pull,hold,verdict,reason\n");

  std::map<std::string, Counts> kinds;
  Counts all;
  std::vector<double> quality_ms, share_of_align;
  for (const made_pairs::Pair& pair : made_pairs::makePairs(scans, repetitions, seed))
    for (const Metric metric : {Metric::Point, Metric::Plane}) {
      const auto [result, judgement, off, right] = made_pairs::judged(pair, metric);
      const Quality& quality = *result.quality;
      kinds[pair.kind].add(right, judgement.verdict);
      all.add(right, judgement.verdict);
      quality_ms.push_back(result.host_times.at("quality").milliseconds);
      share_of_align.push_back(quality_ms.back() / (result.host_times.at("total").milliseconds -
                                                    result.host_times.at("start").milliseconds));
      if (!lines)
        continue;
      const auto surfaces = quality.surfaces.value_or(SurfaceFit());
      std::fprintf(lines,
                   "%s,%s,%s,%d,%g,%zu,%g,%g,%g,%g,%g,%g,%g,%g,%g,%s,\"%s\"\n",
                   pair.kind.c_str(),
                   pair.clouds.c_str(),
                   toString(metric),
                   pair.isRelated() ? 1 : 0,
                   off,
                   pair.source->size(),
                   quality.after.source,
                   quality.after.target,
                   quality.median_distance,
                   quality.concentration,
                   surfaces.share,
                   surfaces.alike,
                   surfaces.distance,
                   surfaces.pull,
                   surfaces.hold,
                   toString(judgement.verdict),
                   judgement.reasons.empty() ? "" : judgement.reasons[0].c_str());
    }
  if (lines)
    std::fclose(lines);

  std::printf("| pairs | right | good | doubtful | wrong | not right | good | doubtful | wrong |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|\n");
  for (const auto& [kind, counts] : kinds)
    printRow(kind, counts);
  printRow("all", all);
  const int good = all.verdicts[0][0] + all.verdicts[1][0];
  std::printf(
      "\nOf %d called good %d are off by more than %g spacings (%.2f %%). Of %d that are right %.1f %% are called "
      "good, %.1f %% doubtful.\n",
      good,
      all.verdicts[0][0],
      made_pairs::right_spacings,
      100.0 * all.verdicts[0][0] / std::max(good, 1),
      all.of(true),
      100.0 * all.verdicts[1][0] / std::max(all.of(true), 1),
      100.0 * all.verdicts[1][1] / std::max(all.of(true), 1));
  std::printf("Measuring takes %.2f ms, %.1f %% of an alignment without the device's start (medians).\n",
              median(quality_ms),
              100 * median(share_of_align));
  return 0;
}
