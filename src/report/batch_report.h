#pragma once

#include "report/pair_result.h"

#include <pcl_gpu_icp/device.h>
#include <pcl_gpu_icp/schedule.h>

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace pcl_gpu_icp::report {

/// A part of a manifest: every pair whose position is number - 1 modulo `of`.
struct Shard {
  std::size_t number = 1; ///< from 1
  std::size_t of = 1;
};

struct ListedOutcome {
  PairIdentity identity;
  PairOutcome outcome;
};

struct TrajectoryReport {
  std::vector<std::string> files;
  std::size_t scans = 0;
  std::size_t poses = 0;
  std::optional<std::size_t> ends_before_pair; ///< the first without a transform
};

/// What a whole batch came to.
struct BatchReport {
  std::vector<std::string> arguments; ///< of the command, and before them its name
  std::optional<Shard> shard;
  std::string results; ///< the file
  std::size_t pairs = 0;
  std::size_t converged = 0;
  std::size_t at_limit = 0;                ///< of the iterations, with an answer
  std::vector<ListedOutcome> unsuccessful; ///< by their positions
  std::size_t good = 0;                    ///< of those that have not failed,
  std::size_t doubtful = 0;
  std::size_t wrong = 0;
  std::vector<ListedOutcome> worst;           ///< up to five answers that are not good, the worst first
  std::size_t kept = 0;                       ///< of an earlier run
  std::size_t aligned = 0;                    ///< in this one
  double wall_s = 0;                          ///< of this one
  std::optional<TrajectoryReport> trajectory; ///< of a sequence

  std::vector<DeviceInfo> devices;
  Policy policy = Policy::SmallestFirst;
  unsigned pairs_in_flight = 0;     ///< 0: the library's default
  std::size_t points_in_flight = 0; ///< 0: no bound
  std::size_t capacity = 0;         ///< 0: as each device reports
  std::map<std::string, std::string> options;

  std::size_t failed() const { return count(PairStatus::Failed); }
  std::size_t notConverged() const { return count(PairStatus::NotConverged); }
  /// Of notConverged(), at the limit of the iterations, and farther than at the guess.
  std::size_t gotWorse() const;
  /// Pairs without a result.
  std::size_t left() const { return pairs - converged - at_limit - unsuccessful.size(); }
  /// Of this run; nothing where it had nothing to do.
  std::optional<double> pairsPerSecond() const;

private:
  std::size_t count(PairStatus status) const;
};

std::string toText(const BatchReport& report);

/// As docs/batch_summary.schema.json describes.
std::string toJson(const BatchReport& report);

} // namespace pcl_gpu_icp::report
