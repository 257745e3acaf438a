#pragma once

#include "report/json.h"
#include "view/pair_view.h"

#include <optional>
#include <string>
#include <vector>

namespace pcl_gpu_icp::view {

/// The data of a page: JSON, and blocks of numbers that it names.
class PageData {
public:
  /// \return the name of the block
  std::string add(const std::vector<float>& numbers);

  /// Adds the clouds of a view.
  /// \param result as `--json` has it
  /// \param errors of the pairs, by iteration
  report::Json pairJson(const PairView& view, const report::Json& result, const std::vector<double>& errors);

  /// The elements of the page that hold it all.
  std::string html(const report::Json& run) const;

private:
  std::string blocks_;
  int count_ = 0;
};

} // namespace pcl_gpu_icp::view
