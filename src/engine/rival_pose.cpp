#include <pcl_gpu_icp/pose_search.h>

#include "feature_matches.h"

#include <algorithm>

namespace pcl_gpu_icp {

namespace {

/// Scores, which go by voxels, are alike for two sides of a relief as well: its points must be as near.
bool fitsNearlyAsWell(const PoseCandidate& pose, const PoseCandidate& best)
{
  constexpr double nearly = 0.9, nearly_as_near = 1.5, noise = 0.05; // spacings
  return pose.score > nearly * best.score &&
         pose.quality.median_distance <= nearly_as_near * best.quality.median_distance + noise;
}

/// Of made rooms of which each cloud has a half, the right pose comes to 0.75 or more of what half a turn comes to.
bool fitsPlainly(const PoseCandidate& pose, const PoseCandidate& best)
{
  constexpr double nearly = 0.7;
  return judge(pose.quality).verdict == Verdict::Good && fitOf(pose.quality) > nearly * fitOf(best.quality);
}

/// Whether features, which tell apart what only points have in common, are all for the best.
bool isOutvoted(const PoseCandidate& pose, const PoseCandidate& best)
{
  constexpr std::size_t times_more = 2;
  return times_more * (pose.support + support_by_chance) <= best.support + support_by_chance;
}

/// The share, of one cloud or the other, that is in view of the other and not there.
double unexplained(const PoseCandidate& pose)
{
  return 1 - std::min(pose.quality.after.source, pose.quality.after.target);
}

/// Whether the best explains all, and the pose does not.
bool isRefuted(const PoseCandidate& pose, const PoseCandidate& best)
{
  constexpr double hardly_any = 0.05, more = 0.02;
  return unexplained(best) <= hardly_any && unexplained(pose) > unexplained(best) + more;
}

} // namespace

const PoseCandidate* PoseSearchResult::rival() const&
{
  const PoseCandidate* rival = nullptr;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const PoseCandidate& pose = poses[i];
    if ((fitsNearlyAsWell(pose, poses[0]) || fitsPlainly(pose, poses[0])) && !isRefuted(pose, poses[0]) &&
        !isOutvoted(pose, poses[0]) && (!rival || fitOf(pose.quality) > fitOf(rival->quality)))
      rival = &pose;
  }
  return rival;
}

} // namespace pcl_gpu_icp
