#pragma once

#include "report/pair_result.h"
#include "view/pair_view.h"

#include <cstddef>
#include <map>
#include <vector>

namespace pcl_gpu_icp::view {

/// The views of a batch's pairs that its page will have: of many pairs few points each, of very many the worst pairs
/// alone.
class BatchGallery {
public:
  struct Entry {
    std::size_t pair; ///< by its position in the manifest
    PairView view;
    std::vector<double> errors; ///< by iteration
  };

  /// \param pairs that there are
  explicit BatchGallery(std::size_t pairs);

  /// How many to show of each cloud.
  std::size_t points() const { return points_; }

  void add(Entry entry, const report::PairOutcome& outcome);

  /// By pair.
  std::map<std::size_t, const Entry*> entries() const;

private:
  std::size_t points_;
  std::size_t most_; ///< pairs
  std::multimap<std::pair<int, double>, Entry> worst_first_;
};

} // namespace pcl_gpu_icp::view
