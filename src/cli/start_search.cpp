#include "cli/start_search.h"

#include <pcl_gpu_icp/overlap_search.h>
#include <pcl_gpu_icp/point_covariances.h>
#include <pcl_gpu_icp/pose_search.h>
#include <pcl_gpu_icp/search/points_of.h>
#include <pcl_gpu_icp/stopwatch.h>

#include <cmath>
#include <utility>

namespace pcl_gpu_icp::cli {
namespace {

/// What a distance across a surface is to the metric.
double residualOf(double distance, Metric metric)
{
  return metric == Metric::Generalized ? distance / std::sqrt(2 * surface_epsilon) : distance;
}

} // namespace

StartSearch::StartSearch(const Device& device, std::shared_ptr<DeviceShare> share, StageTimes& times, Progress progress)
: device_(device)
, share_(std::move(share))
, times_(times)
, progress_(std::move(progress))
{
}

template <typename Search>
Search StartSearch::searchOf(const AlignmentOptions& options) const
{
  Search search(device_);
  search.setMotions(options.motions);
  search.setShare(share_);
  return search;
}

std::optional<Start> StartSearch::fromAnywhere(const Start& start) const
{
  const Stopwatch watch(times_, "guess");
  Start result = start;
  CloudPair& pair = result.pair;
  auto search = searchOf<PoseSearch>(start.options);
  search.setProgress(progress_);
  const Points source = search::pointsOf(*pair.source->points), target = search::pointsOf(*pair.target->points);
  const PoseSearchResult found = search.search(source, target, pair.guess);
  if (found.poses.empty())
    return std::nullopt;
  pair.guess = found.poses[0].transform;
  report::SearchedGuess& searched = result.searched_guess.emplace();
  searched.starts = found.starts;
  searched.score = found.poses[0].score;
  if (found.poses.size() > 1)
    searched.next_score = found.poses[1].score;
  const auto inFiles = [&pair](const PoseCandidate& pose) {
    return report::FoundPose{pair.inFileCoordinates(pose.transform), pose.quality.after.source};
  };
  searched.found = inFiles(found.poses[0]);
  if (const PoseCandidate* rival = found.rival())
    searched.rival = inFiles(*rival);
  return result;
}

std::optional<Start> StartSearch::fromOverlap(const Start& start) const
{
  const Stopwatch watch(times_, "overlap");
  Start result = start;
  CloudPair& pair = result.pair;
  const OverlapSearchResult found =
      searchOf<OverlapSearch>(start.options)
          .search(search::pointsOf(*pair.source->points), search::pointsOf(*pair.target->points), pair.guess);
  if (found.ways == 0)
    return std::nullopt;
  pair.guess = found.transform;
  if (!result.options.loss_is_given)
    result.options.loss = {LossFunction::GemanMcClure, residualOf(found.quality.spacing, result.options.metric)};
  result.found_overlap = {found.quality.after.source, found.ways};
  return result;
}

} // namespace pcl_gpu_icp::cli
