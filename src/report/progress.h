#pragma once

#include "report/pair_result.h"

#include <cstddef>
#include <string>

namespace pcl_gpu_icp::report {

/// How far a batch has come.
struct Progress {
  std::size_t pairs = 0;        ///< in all
  std::size_t done = 0;         ///< have a result
  std::size_t unsuccessful = 0; ///< of these
  std::size_t aligned = 0;      ///< of these, in this run
  double seconds = 0;           ///< since it began
};

/// One line for a terminal: a bar, counts, rate and time left.
std::string barText(const Progress& progress);

/// One line for a pair that has just finished.
std::string lineText(const Progress& progress, const PairIdentity& identity, const PairOutcome& outcome);

/// What became of a pair, in words.
std::string outcomeText(const PairOutcome& outcome);

} // namespace pcl_gpu_icp::report
