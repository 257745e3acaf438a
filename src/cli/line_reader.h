#pragma once

#include "cli/number.h"

#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// What the readers of files that have lines hold.
class LineReader {
public:
  LineReader(const std::string& path, std::string_view content)
  : path_(path)
  , rest_(content)
  , line_end_(lineEnd(content))
  {
  }

protected:
  const std::string& path_;
  std::string_view rest_; ///< what has not been read yet
  char line_end_;
};

} // namespace pcl_gpu_icp::cli
