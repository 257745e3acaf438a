#pragma once

#include "report/alignment_report.h"

#include <pcl_gpu_icp/rigid_transform.h>

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace pcl_gpu_icp::report {

/// Which alignment of a batch a result is of.
struct PairIdentity {
  std::size_t pair = 0; ///< position in the manifest, from 0
  std::string source;   ///< file names as listed
  std::string target;
  std::map<std::string, std::string> options; ///< those given, by their names without dashes
};

enum class PairStatus {
  Converged,
  AtLimit,      ///< Ending::AtLimit
  NotConverged, ///< any other without an answer
  Failed,
};

const char* toString(PairStatus status);

/// Whether there is a transform to go on with.
constexpr bool isAnswer(PairStatus status) { return status == PairStatus::Converged || status == PairStatus::AtLimit; }

/// Why a pair has no alignment.
struct PairFailure {
  std::string kind; ///< as the exit codes of the command are called
  std::string message;
};

/// What a batch needs to know of a pair's result once it is written.
struct PairOutcome {
  PairStatus status = PairStatus::Failed;
  bool got_worse = false;   ///< Ending::GotWorse
  RigidTransform transform; ///< where there is one
  std::string why;          ///< endingText() of what is no answer, or the failure's message
  int iterations = 0;
  std::size_t warnings = 0;
  std::optional<double> rmse;
  Judgement judgement; ///< of what has not failed
  double near = 0;     ///< the share of the source's points that are near the target; 0: not measured
};

PairOutcome outcomeOf(const AlignmentReport& report);
PairOutcome outcomeOf(const PairFailure& failure);

/// A line of the results, as docs/batch.schema.json describes.
std::string resultLine(const PairIdentity& identity, const AlignmentReport& report);
std::string resultLine(const PairIdentity& identity, const PairFailure& failure);

/// What such a line says.
struct ReadResult {
  std::size_t pair = 0;
  std::string identity; ///< as identityText()
  PairOutcome outcome;
};

/// \return nothing where it is no line of the results
std::optional<ReadResult> readResultLine(std::string_view line);

/// The same for results of the same alignment.
std::string identityText(const PairIdentity& identity);

} // namespace pcl_gpu_icp::report
