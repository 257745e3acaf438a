#include "cli/guess_search.h"

#include "cli/failure.h"
#include "cli/guess.h"

#include "report/format.h"

#include <pcl_gpu_icp/overlap_search.h>
#include <pcl_gpu_icp/pose_search.h>
#include <pcl_gpu_icp/quality.h>
#include <pcl_gpu_icp/search/points_of.h>
#include <pcl_gpu_icp/stopwatch.h>

#include <utility>

namespace pcl_gpu_icp::cli {
namespace {

/// Whether the points are as near the target at the second pose as at the first, or nearly so: scores alone, which go
/// by voxels, are alike for two sides of a relief as well.
bool fitsAsClosely(const Points& source, const Points& target, const PoseSearchResult& found)
{
  constexpr double nearly = 1.5, noise = 0.05; // spacings
  const auto medianAt = [&](const PoseCandidate& pose) {
    return qualityOf(source, target, pose.transform, pose.transform).median_distance;
  };
  return medianAt(found.poses[1]) <= nearly * medianAt(found.poses[0]) + noise;
}

} // namespace

std::optional<report::SearchedGuess> searchGuess(CloudPair& pair,
                                                 const AlignmentOptions& options,
                                                 const Device& device,
                                                 std::shared_ptr<DeviceShare> share,
                                                 StageTimes& times,
                                                 std::function<void(std::size_t done, std::size_t all)> progress)
{
  if (!options.guess || !asksForSearch(*options.guess))
    return std::nullopt;
  const Stopwatch watch(times, "guess");
  PoseSearch search(device);
  search.setMotions(options.motions);
  search.setShare(std::move(share));
  search.setProgress(std::move(progress));
  const Points source = search::pointsOf(*pair.source->points), target = search::pointsOf(*pair.target->points);
  const PoseSearchResult found = search.search(source, target, pair.guess);
  const std::string files = options.source + " onto " + options.target;
  if (found.poses.empty())
    throw Failure(ExitCode::Input,
                  files +
                      ": --guess auto found no pose: it takes clouds of one size, of at least 10 points that are not "
                      "all at one place");
  pair.guess = found.poses[0].transform;
  report::SearchedGuess searched{found.starts, found.poses[0].score, std::nullopt, false};
  if (found.poses.size() > 1)
    searched.next_score = found.poses[1].score;
  searched.is_ambiguous = found.isAmbiguous() && fitsAsClosely(source, target, found);
  constexpr double low = 0.3; // scans of one place have more
  if (searched.score < low)
    pair.warnings.push_back(report::format(
        "%s: the best pose that was found fits badly, with a score of %.2g of 1", files.c_str(), searched.score));
  if (searched.is_ambiguous)
    pair.warnings.push_back(report::format("%s: two poses fit nearly as well, with scores of %.2g and %.2g: the first "
                                           "was taken",
                                           files.c_str(),
                                           searched.score,
                                           *searched.next_score));
  return searched;
}

std::optional<report::FoundOverlap> findOverlap(CloudPair& pair,
                                                AlignmentOptions& options,
                                                const Device& device,
                                                std::shared_ptr<DeviceShare> share,
                                                StageTimes& times)
{
  if (!options.finds_overlap)
    return std::nullopt;
  const Stopwatch watch(times, "overlap");
  OverlapSearch search(device);
  search.setMotions(options.motions);
  search.setShare(std::move(share));
  const OverlapSearchResult found =
      search.search(search::pointsOf(*pair.source->points), search::pointsOf(*pair.target->points), pair.guess);
  if (found.ways == 0)
    throw Failure(ExitCode::Input,
                  options.source + " onto " + options.target +
                      ": --overlap auto takes clouds of at least 10 points that are not all at one place");
  pair.guess = found.transform;
  if (!options.loss.weighs())
    options.loss = {LossFunction::GemanMcClure, found.quality.spacing};
  return report::FoundOverlap{found.quality.after.source, found.ways};
}

} // namespace pcl_gpu_icp::cli
