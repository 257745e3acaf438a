#include "cli/batch_ledger.h"

#include "cli/input_file.h"
#include "cli/number.h"

#include <algorithm>

namespace pcl_gpu_icp::cli {

BatchLedger::BatchLedger(const std::vector<ListedPair>& pairs, const std::string& path, std::string_view lines)
: pairs_(pairs)
, outcomes_(pairs.size())
{
  for (std::size_t line = 1; !lines.empty(); ++line) {
    const auto fail = [&](const std::string& why) { return inputFailure(path + ":" + std::to_string(line), why); };
    const auto read = report::readResultLine(nextLine(lines));
    if (!read)
      throw fail("is no result of a batch");
    const std::string pair = "pair " + std::to_string(read->pair);
    const std::size_t place = placeOf(read->pair);
    if (place == pairs_.size())
      throw fail(pair + " is not among those to align");
    const report::PairIdentity& identity = pairs_[place].identity;
    if (read->identity != report::identityText(identity))
      throw fail(pair + " was aligned with another source, target or options than " + identity.source + " onto " +
                 identity.target + " has now");
    if (has(place))
      throw fail(pair + " is there twice");
    add(place, read->outcome);
  }
}

std::size_t BatchLedger::placeOf(std::size_t pair) const
{
  const auto found =
      std::lower_bound(pairs_.begin(), pairs_.end(), pair, [](const ListedPair& listed, std::size_t number) {
        return listed.identity.pair < number;
      });
  return found != pairs_.end() && found->identity.pair == pair ? static_cast<std::size_t>(found - pairs_.begin())
                                                               : pairs_.size();
}

void BatchLedger::describe(report::BatchReport& report) const
{
  report.pairs = pairs_.size();
  for (std::size_t place = 0; place < pairs_.size(); ++place) {
    const auto& outcome = outcomes_[place];
    if (!outcome)
      continue;
    if (outcome->status != report::PairStatus::Failed) {
      const Verdict verdict = outcome->judgement.verdict;
      ++(verdict == Verdict::Good ? report.good : verdict == Verdict::Doubtful ? report.doubtful : report.wrong);
      if (verdict != Verdict::Good && isAnswer(outcome->status))
        report.worst.push_back({pairs_[place].identity, *outcome});
    }
    if (outcome->status == report::PairStatus::Converged)
      ++report.converged;
    else if (outcome->status == report::PairStatus::AtLimit)
      ++report.at_limit;
    else
      report.unsuccessful.push_back({pairs_[place].identity, *outcome});
  }
  constexpr std::size_t most_named = 5;
  std::stable_sort(report.worst.begin(), report.worst.end(), [](const auto& a, const auto& b) {
    return a.outcome.near < b.outcome.near;
  });
  report.worst.resize(std::min(report.worst.size(), most_named));
}

} // namespace pcl_gpu_icp::cli
