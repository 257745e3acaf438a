#pragma once

#include "cli/failure.h"

#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

/// A file that grows by lines, each of them there whole or not at all, whatever ends the process. One process at a time
/// has it.
class ResultsFile {
public:
  /// What is done with a file that exists. An empty one, of a run that was ended before its first result, is as good as
  /// none.
  enum class Existing { Refused, Emptied, Continued };

  /// \throws Failure (Output) where it exists and is refused, cannot be written, or another process writes it
  ResultsFile(const std::string& path, Existing existing);
  ~ResultsFile();
  ResultsFile(const ResultsFile&) = delete;
  ResultsFile& operator=(const ResultsFile&) = delete;

  /// Where it exists and is refused.
  static Failure refusal(const std::string& path);

  /// The whole lines that it had; a part of a line at the end has been cut off.
  const std::string& kept() const { return kept_; }

  /// \param line with its line feed
  /// \throws Failure (Output), and the file is as it was
  void append(std::string_view line);

  const std::string& path() const { return path_; }

private:
  [[noreturn]] void fail(const std::string& why) const;
  void open(Existing existing);

  std::string path_;
  std::string kept_;
  std::size_t size_ = 0;
  int file_ = -1;
};

} // namespace pcl_gpu_icp::cli
