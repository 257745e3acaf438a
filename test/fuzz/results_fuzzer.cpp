#include "harness.h"

#include "cli/batch_ledger.h"

#include <cmath>

using namespace pcl_gpu_icp;

namespace {

std::vector<cli::ListedPair> listedPairs()
{
  std::vector<cli::ListedPair> pairs(3);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    pairs[i].identity = {i, "s.pcd", "t.pcd", {}};
  pairs[2].identity.options = {{"leaf", "0.5"}};
  return pairs;
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  static const std::vector<cli::ListedPair> pairs = listedPairs();
  const std::string path = "results.jsonl";
  fuzz::reads(path, [&] {
    const cli::BatchLedger ledger(pairs, path, fuzz::textOf(data, size));
    for (const auto& outcome : ledger.outcomes()) {
      if (!outcome || outcome->status == report::PairStatus::Failed)
        continue;
      fuzz::require(outcome->iterations >= 0, "iterations are counted from 0");
      for (const double value : outcome->transform.rotation)
        fuzz::require(std::isfinite(value), "a transform is finite");
    }
  });
  return 0;
}
