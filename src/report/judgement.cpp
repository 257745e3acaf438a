#include "report/judgement.h"

#include "report/difference.h"
#include "report/ending.h"
#include "report/format.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace pcl_gpu_icp::report {
namespace {

Json numberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json overlapJson(double before, double after) { return {{"before", before}, {"after", after}}; }

bool hasRival(const AlignmentReport& report) { return report.searched_guess && report.searched_guess->rival; }

} // namespace

bool liesWell(const AlignmentReport& report)
{
  return report.result.quality && judge(*report.result.quality).verdict == Verdict::Good;
}

bool isDoubtedForRivalAlone(const AlignmentReport& report)
{
  return hasRival(report) && liesWell(report) && degeneracyOf(report.result) == Degeneracy::None;
}

Judgement judgementOfPose(const AlignmentReport& report)
{
  Judgement judgement = report.result.quality ? judge(*report.result.quality) : Judgement{Verdict::Doubtful, {}};
  const auto doubt = [&judgement](const std::string& reason) {
    judgement.verdict = std::max(judgement.verdict, Verdict::Doubtful);
    judgement.reasons.insert(judgement.reasons.begin(), reason);
  };
  if (degeneracyOf(report.result) != Degeneracy::None)
    doubt("not determined: " + undeterminedText(report.result));
  if (judgement.verdict != Verdict::Wrong && hasRival(report)) {
    const FoundPose& rival = *report.searched_guess->rival;
    const Difference difference = differenceOf(rival.transform, report.transform, report.centroid);
    doubt(
        format("two poses fit: another, %.0f degrees and %.3g from this one, has %.0f %% of the source's points within "
               "three spacings of the target",
               difference.degrees,
               difference.metres,
               100 * rival.near));
  }
  return judgement;
}

Judgement judgementOf(const AlignmentReport& report)
{
  switch (endingOf(report)) {
  case Ending::GotWorse:
  case Ending::TooCoarse:
  case Ending::TooFewPairs:
    return {Verdict::Wrong, {plainEndingText(report)}};
  default:
    return judgementOfPose(report);
  }
}

std::vector<std::string> adviceFor(const AlignmentReport& report)
{
  const AlignmentResult& result = report.result;
  std::vector<std::string> advice;
  if (endingOf(report) == Ending::TooCoarse)
    return {"a smaller --leaf"};
  const Verdict verdict = judgementOf(report).verdict;
  const bool is_determined = degeneracyOf(result) == Degeneracy::None;
  if (verdict == Verdict::Good || !result.quality || (verdict == Verdict::Doubtful && !is_determined))
    return advice;
  const auto has = [&report](bool TriedStart::*kind) {
    return std::any_of(report.tried.begin(), report.tried.end(), std::mem_fn(kind));
  };
  if (!has(&TriedStart::searched))
    advice.push_back(report.once ? "without --once other starts are tried"
                                 : "--guess auto searches for where to start");
  if (!is_determined)
    return advice;
  if (verdict == Verdict::Doubtful && hasRival(report))
    advice.push_back("--guess with a rough pose, where one is known, decides between them");
  if (result.reason == Reason::Iterations && result.iterations == report.iteration_limit)
    advice.push_back("--iterations allows more of them: these were the last allowed");
  if (report.max_distance && result.inliers == result.source_points)
    advice.push_back(format("a smaller --max-distance: %g leaves out no pair", *report.max_distance));
  if (verdict == Verdict::Doubtful && !isDoubtedForRivalAlone(report) && !has(&TriedStart::overlap) &&
      result.quality->after.source < 1)
    advice.push_back("--overlap auto takes clouds that overlap in part");
  return advice;
}

std::string judgementText(const Judgement& judgement)
{
  std::string text = toString(judgement.verdict);
  for (const std::string& reason : judgement.reasons)
    text += (&reason == judgement.reasons.data() ? ": " : "; ") + reason;
  return text;
}

std::string qualityText(const Quality& quality)
{
  const auto percent = [](double share) { return 100 * share; };
  return format("near       within %.3g, three spacings: %.0f %% of the source's points, %.0f %% at the guess; of the "
                "target's in view %.0f %%, %.0f %%\n",
                3 * quality.spacing,
                percent(quality.after.source),
                percent(quality.before.source),
                percent(quality.after.target),
                percent(quality.before.target));
}

Json qualityJson(const Quality& quality)
{
  Json json{{"spacing", quality.spacing},
            {"source_near", overlapJson(quality.before.source, quality.after.source)},
            {"target_near", overlapJson(quality.before.target, quality.after.target)},
            {"median_distance", numberOrNull(quality.median_distance)},
            {"concentration", quality.concentration},
            {"surfaces", nullptr}};
  if (const auto& surfaces = quality.surfaces)
    json["surfaces"] = {{"share", surfaces->share},
                        {"alike", surfaces->alike},
                        {"distance", numberOrNull(surfaces->distance)},
                        {"pull", surfaces->pull},
                        {"hold", surfaces->hold}};
  return json;
}

} // namespace pcl_gpu_icp::report
