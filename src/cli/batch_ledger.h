#pragma once

#include "cli/listed_pair.h"

#include "report/batch_report.h"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pcl_gpu_icp::cli {

/// The results of the pairs of a batch, as far as there are any. Pairs are named by their place in the list.
class BatchLedger {
public:
  /// Starts with what a results file has already, in whole lines.
  /// \throws Failure (Input) that names a line that is no result, or one of something that the list does not have
  BatchLedger(const std::vector<ListedPair>& pairs, const std::string& path, std::string_view lines);

  bool has(std::size_t place) const { return outcomes_[place].has_value(); }
  void add(std::size_t place, const report::PairOutcome& outcome) { outcomes_[place] = outcome; }

  /// Enters counts and what was not successful.
  void describe(report::BatchReport& report) const;

  const std::vector<std::optional<report::PairOutcome>>& outcomes() const { return outcomes_; }

private:
  std::size_t placeOf(std::size_t pair) const;

  const std::vector<ListedPair>& pairs_;
  std::vector<std::optional<report::PairOutcome>> outcomes_;
};

} // namespace pcl_gpu_icp::cli
