#pragma once

#include "report/alignment_report.h"

#include <string>

namespace pcl_gpu_icp::report {

/// What an alignment came to: exit codes, the status of a batch's pairs and what is said of them follow from it.
enum class Ending {
  Converged,
  AtLimit,      ///< the iterations ended before they converged
  GotWorse,     ///< and farther from the target than at the guess, where surfaces do not lie on each other well
  Undetermined, ///< the matched points leave motions free
  Wrong,        ///< they ended at a pose that judge() calls wrong
  Doubtful,     ///< or doubtful, where only a good one counts
  TooCoarse,    ///< the voxel grid left what a single voxel would leave
  TooFewPairs,
};

const char* toString(Ending ending);

Ending endingOf(const AlignmentReport& report);

/// Whether there is a transform to go on with. At the iteration limit there is, as in PCL.
constexpr bool isAnswer(Ending ending) { return ending == Ending::Converged || ending == Ending::AtLimit; }

/// Positive where the source is farther from the target than at the guess; 0 where float coordinates cannot tell.
double changeOfDistance(const AlignmentReport& report);

/// What the pairs leave undetermined, those too few to be estimated from included.
Degeneracy degeneracyOf(const AlignmentResult& result);

/// The same in words; "nothing" for nothing.
std::string undeterminedText(const AlignmentResult& result);

/// As an answer to whether there is anything of it.
std::string degeneracyText(const AlignmentResult& result);

/// How the alignment ended.
std::string plainEndingText(const AlignmentReport& report);

/// The same, and whether that is an answer.
std::string endingText(const AlignmentReport& report);

} // namespace pcl_gpu_icp::report
