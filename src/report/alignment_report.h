#pragma once

#include "report/difference.h"

#include <pcl_gpu_icp/result.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pcl_gpu_icp::report {

/// What became of the points of a file before the alignment saw them.
struct PointCounts {
  std::size_t in_file = 0;
  std::size_t non_finite = 0;   ///< a coordinate is NaN, infinite or beyond float
  std::size_t too_large = 0;    ///< a coordinate is beyond largest_coordinate
  std::size_t zero_returns = 0; ///< exactly at (0, 0, 0), dropped on request
  std::size_t downsampled = 0;  ///< merged with others by the voxel grid
  std::size_t coincident = 0;   ///< target only: repeat another point
  std::size_t used = 0;
};

/// A pose that a search found.
struct FoundPose {
  RigidTransform transform; ///< source to target, in the coordinates of the files
  double near = 0;          ///< share of the source's points within three spacings of the target
};

/// What a search for the guess came to, whether or not the pose that was taken started from it.
struct SearchedGuess {
  std::size_t starts = 0; ///< poses that were tried
  double score = 0;       ///< of the best, from 0 to 1
  std::optional<double> next_score;
  FoundPose found;                ///< the best; where there is a rival, the one of the two that was taken
  std::optional<FoundPose> rival; ///< another, which fits as well for all that can be told from the clouds
};

/// What a search for what the clouds have in common came to.
struct FoundOverlap {
  double share = 0;     ///< of the source's points, that have a partner there
  std::size_t ways = 0; ///< that were tried
};

/// Where an alignment started, and what came of it.
struct TriedStart {
  bool searched = false; ///< from anywhere; else the guess
  bool overlap = false;  ///< and from there by what the clouds have in common
  Verdict verdict = Verdict::Wrong;
  bool taken = false;
};

struct AlignmentReport {
  std::vector<std::string> arguments; ///< of the command, and before them its name
  std::string source;                 ///< file names as given
  std::string target;
  PointCounts source_points;
  PointCounts target_points;
  AlignmentResult result;
  std::array<double, 3> centroid{};            ///< of the source
  RigidTransform guess;                        ///< source to target, in the coordinates of the files, and
  RigidTransform transform;                    ///< where that ended
  std::optional<SearchedGuess> searched_guess; ///< none: there was no search
  std::optional<FoundOverlap> found_overlap;   ///< none: it was not searched for
  std::vector<TriedStart> tried;               ///< in this order, of which one was taken
  std::optional<double> fitness_score;
  bool only_good = false;          ///< a doubtful pose is no answer
  bool once = false;               ///< no other start was to be tried
  bool takes_undetermined = false; ///< motions that are not determined are no reason for having no answer
  int iteration_limit = 0;
  std::optional<double> max_distance;     ///< between matched points
  std::optional<double> nearest_distance; ///< where the pairs are too few: the least of a source point from the target
  double resolution = 0;                  ///< a change of the RMSE that float coordinates cannot show
  std::vector<std::string> warnings;      ///< what of the files may not be as meant, a line each
  StageTimes command_times;               ///< what the command did around the alignment, and "total"
};

/// "the guess", "what they have in common", "a search", "a search and what they have in common".
std::string nameOf(const TriedStart& start);

struct TextStyle {
  bool verbose = false;  ///< every time that was taken
  bool coloured = false; ///< the verdict, for a terminal
};

/// What a reader asks first comes first.
std::string toText(const AlignmentReport& report, const TextStyle& style = {});

/// As docs/align.schema.json describes.
std::string toJson(const AlignmentReport& report);

} // namespace pcl_gpu_icp::report
