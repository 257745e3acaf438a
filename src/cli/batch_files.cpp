#include "cli/batch_files.h"

#include "cli/failure.h"

#include "report/format.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <sys/stat.h>

namespace pcl_gpu_icp::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* option = "-o";

void make(const std::string& directory)
{
  std::error_code error;
  if (mkdir(directory.c_str(), 0777) != 0 && !(errno == EEXIST && fs::is_directory(directory, error)))
    throw Failure(ExitCode::Output,
                  std::string(option) + " " + directory + ": " +
                      (errno == EEXIST ? "exists and is not a directory" : std::strerror(errno)));
}

} // namespace

BatchFiles::BatchFiles(const std::string& directory,
                       const std::optional<report::Shard>& shard,
                       bool has_trajectory,
                       const std::string& trace_path,
                       const std::string& page_path,
                       ResultsFile::Existing existing)
{
  make(directory);
  const bool overwrite = existing != ResultsFile::Existing::Refused;
  const std::string part = shard ? report::format("-%zu-of-%zu", shard->number, shard->of) : "";
  const auto in_directory = [&](const std::string& name) { return (fs::path(directory) / name).string(); };
  const auto open = [&](const std::string& name) {
    return std::make_unique<OutputFile>(option, in_directory(name), overwrite);
  };
  const std::string results_path = in_directory("results" + part + ".jsonl");
  std::error_code error;
  if (!overwrite && fs::exists(results_path) && fs::file_size(results_path, error) != 0)
    throw ResultsFile::refusal(results_path);
  if (has_trajectory) {
    kitti = open("trajectory.kitti.txt");
    tum = open("trajectory.tum.txt");
  }
  summary = open("summary" + part + ".json");
  if (!trace_path.empty())
    trace = std::make_unique<OutputFile>("--trace", trace_path, overwrite);
  if (!page_path.empty())
    page = std::make_unique<OutputFile>("--report", page_path, overwrite);
  requireDistinct({trace.get(), page.get()});
  for (const std::string& taken : {fs::weakly_canonical(results_path).string(),
                                   summary->location(),
                                   kitti ? kitti->location() : "",
                                   tum ? tum->location() : ""})
    for (const auto* file : {&trace, &page})
      if (*file && (*file)->location() == taken)
        throw Failure(ExitCode::Usage, (*file)->option() + " " + (*file)->path() + " is a file that -o has");
  // Last, because it leaves a file where there was none.
  results = std::make_unique<ResultsFile>(results_path, existing);
}

void BatchFiles::commit() { OutputFile::commit({kitti.get(), tum.get(), trace.get(), page.get(), summary.get()}); }

} // namespace pcl_gpu_icp::cli
