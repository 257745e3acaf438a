#pragma once

#include "cli/output_file.h"
#include "cli/results_file.h"

#include "report/batch_report.h"

#include <memory>
#include <optional>
#include <string>

namespace pcl_gpu_icp::cli {

/// The files that a batch writes: all but the trace and the page into its directory, which it makes where there is
/// none.
struct BatchFiles {
  /// \throws Failure (Output) where one exists and is refused, or cannot be written
  BatchFiles(const std::string& directory,
             const std::optional<report::Shard>& shard,
             bool has_trajectory,
             const std::string& trace_path,
             const std::string& page_path,
             ResultsFile::Existing existing);

  /// Gives those but the results, which have been written, their names.
  void commit();

  std::unique_ptr<OutputFile> kitti; ///< null where there is no trajectory
  std::unique_ptr<OutputFile> tum;
  std::unique_ptr<OutputFile> trace; ///< null where none was asked for
  std::unique_ptr<OutputFile> page;  ///< of --report, so too
  std::unique_ptr<OutputFile> summary;
  std::unique_ptr<ResultsFile> results;
};

} // namespace pcl_gpu_icp::cli
