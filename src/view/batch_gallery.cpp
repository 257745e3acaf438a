#include "view/batch_gallery.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace pcl_gpu_icp::view {
namespace {

constexpr std::size_t points_in_all = 90000; // of either cloud: with three coordinates or distances each 4 MB of base64

} // namespace

BatchGallery::BatchGallery(std::size_t pairs)
: points_(std::clamp<std::size_t>(points_in_all / std::max<std::size_t>(pairs, 1), 400, 15000))
, most_(points_in_all / points_)
{
}

void BatchGallery::add(Entry entry, const report::PairOutcome& outcome)
{
  worst_first_.emplace(std::pair(-static_cast<int>(outcome.judgement.verdict), outcome.near), std::move(entry));
  if (worst_first_.size() > most_)
    worst_first_.erase(std::prev(worst_first_.end()));
}

std::map<std::size_t, const BatchGallery::Entry*> BatchGallery::entries() const
{
  std::map<std::size_t, const Entry*> entries;
  for (const auto& [order, entry] : worst_first_)
    entries[entry.pair] = &entry;
  return entries;
}

} // namespace pcl_gpu_icp::view
