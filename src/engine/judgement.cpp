#include <pcl_gpu_icp/quality.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace pcl_gpu_icp {

namespace {

/// Set on pairs of known answers; BENCHMARK.md tells what they come to on others (bench/verdict_benchmark).
namespace limits {
// A pose is good where the clouds lie on each other as a whole, or very closely, or plainly in part.
constexpr double whole = 0.88, whole_concentration = 0.7, whole_alike = 0.85, whole_distance = 0.45;
constexpr double closely = 0.9, closely_median = 0.4;
// Scattered points that are closer than their spacing need not be in their place.
constexpr double scattered_median = 0.1;
constexpr double part = 0.3, part_concentration = 0.75, part_alike = 0.95, part_distance = 0.25, part_pull = 1;
// And holds, where it is.
constexpr double pull = 1.6, hold = 0.005;
// Where surfaces hold so little, such as terrain seen from the air, points must be nearer to show a motion along them.
constexpr double weak_hold = 0.012, weak_median = 0.6;
// It is wrong where what is near lies there as by chance, unless a robust step would leave it there.
constexpr double near_by_chance = 0.25, concentration_by_chance = 0.42, alike_by_chance = 0.4, distance_by_chance = 0.8;
constexpr double stays_pull = 1.2, stays_alike = 0.7;
} // namespace limits

std::string text(const char* format, double value, double unit = 0)
{
  char buffer[200];
  std::snprintf(buffer, sizeof(buffer), format, value, unit);
  return buffer;
}

double percent(double share) { return 100 * share; }

bool stays(const Quality& quality)
{
  return quality.surfaces && quality.surfaces->hold >= limits::hold && quality.surfaces->alike >= limits::stays_alike &&
         quality.surfaces->pull <= limits::stays_pull;
}

bool liesClosely(const Quality& quality)
{
  return quality.after.source >= limits::closely &&
         quality.median_distance <= (quality.surfaces ? limits::closely_median : limits::scattered_median);
}

/// Why the points that are near could be so by chance.
std::vector<std::string> chances(const Quality& quality)
{
  if (stays(quality))
    return {};
  if (quality.after.source < limits::near_by_chance)
    return {text("only %.0f %% of the source's points are within three spacings (%.3g) of the target",
                 percent(quality.after.source),
                 3 * quality.spacing)};
  std::vector<std::string> reasons;
  if (quality.concentration < limits::concentration_by_chance)
    reasons.push_back(text("the points near the target lie no closer than by chance: %.0f %% of those within three "
                           "spacings (%.3g) are within one",
                           percent(quality.concentration),
                           3 * quality.spacing));
  if (!quality.surfaces || liesClosely(quality))
    return reasons;
  const SurfaceFit& surfaces = *quality.surfaces;
  if (surfaces.alike < limits::alike_by_chance && !std::isinf(surfaces.distance))
    reasons.push_back(
        text("the surfaces cross: of those that are near each other %.0f %% are parallel", percent(surfaces.alike)));
  else if (surfaces.distance > limits::distance_by_chance && !std::isinf(surfaces.distance))
    reasons.push_back(text("the surfaces lie beside each other, %.2g spacings (%.3g) apart",
                           surfaces.distance,
                           surfaces.distance * quality.spacing));
  return reasons;
}

/// What speaks against it, where no chance does.
std::vector<std::string> doubts(const Quality& quality)
{
  std::vector<std::string> reasons;
  const double near = quality.after.source;
  const bool has_surfaces = quality.surfaces && !std::isinf(quality.surfaces->distance);
  const SurfaceFit surfaces = quality.surfaces.value_or(SurfaceFit());
  const bool as_a_whole = near >= limits::whole && quality.concentration >= limits::whole_concentration &&
                          has_surfaces && surfaces.alike >= limits::whole_alike &&
                          surfaces.distance <= limits::whole_distance;
  const bool in_part = near >= limits::part && quality.concentration >= limits::part_concentration && has_surfaces &&
                       surfaces.alike >= limits::part_alike && surfaces.distance <= limits::part_distance &&
                       surfaces.pull <= limits::part_pull;
  const bool fits = as_a_whole || in_part || liesClosely(quality);
  if (!fits && near < limits::whole)
    reasons.push_back(text("%.0f %% of the source's points are within three spacings (%.3g) of the target: the clouds "
                           "overlap in part, or the pose is wrong",
                           percent(near),
                           3 * quality.spacing));
  const double enough_hold = quality.median_distance <= limits::weak_median ? limits::hold : limits::weak_hold;
  if (quality.surfaces && surfaces.hold < enough_hold)
    reasons.push_back(text(
        "the surfaces hardly hold a motion along them (%.2g of 1, where %.2g would do)", surfaces.hold, enough_hold));
  if (surfaces.pull > limits::pull)
    reasons.push_back(text("a robust step from there would move the points by %.2g spacings (%.3g)",
                           surfaces.pull,
                           surfaces.pull * quality.spacing));
  if (fits)
    return reasons;
  if (has_surfaces && surfaces.alike < limits::whole_alike)
    reasons.push_back(
        text("of the surfaces that are near each other only %.0f %% are parallel", percent(surfaces.alike)));
  if (has_surfaces && surfaces.distance > limits::whole_distance)
    reasons.push_back(
        text("the surfaces are %.2g spacings (%.3g) apart", surfaces.distance, surfaces.distance * quality.spacing));
  if (quality.concentration < limits::whole_concentration)
    reasons.push_back(text("only %.0f %% of the points within three spacings (%.3g) of the target are within one",
                           percent(quality.concentration),
                           3 * quality.spacing));
  if (reasons.empty())
    reasons.push_back(text("the points are %.2g spacings (%.3g) from the target, and there are no surfaces to tell by",
                           quality.median_distance,
                           quality.median_distance * quality.spacing));
  return reasons;
}

} // namespace

const char* toString(Verdict verdict)
{
  switch (verdict) {
  case Verdict::Good:
    return "good";
  case Verdict::Doubtful:
    return "doubtful";
  case Verdict::Wrong:
    return "wrong";
  }
  return "unknown";
}

Judgement judge(const Quality& quality)
{
  if (!(quality.spacing > 0))
    return {Verdict::Doubtful, {"the clouds have too few points, or all at one place, to tell"}};
  auto reasons = doubts(quality);
  if (reasons.empty())
    return {Verdict::Good, {}};
  auto wrong = chances(quality);
  return wrong.empty() ? Judgement{Verdict::Doubtful, std::move(reasons)} : Judgement{Verdict::Wrong, std::move(wrong)};
}

} // namespace pcl_gpu_icp
