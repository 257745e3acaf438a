#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace pcl_gpu_icp::cli {

/// A file that appears whole or not at all: the content goes to a temporary file beside it, which takes its name last.
class OutputFile {
public:
  /// Finds out before any work is done whether the file can be written.
  /// \param option the argument that names it, for messages
  /// \throws Failure (Output) where it exists and `overwrite` is not set, or cannot be written
  OutputFile(std::string option, const std::string& path, bool overwrite);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// \throws Failure (Output)
  void write(std::string_view content);
  /// Gives what was written to each its name: to all, or, where that fails for one, to none. Where a file system cannot
  /// exchange two files, those that were overwritten before it stay so.
  /// \param files null ones are none
  /// \throws Failure (Output)
  static void commit(const std::vector<OutputFile*>& files);

  /// Removes all temporary files that there are. For a process that ends at once: nothing can be written any more.
  static void endAll();

  const std::string& option() const { return option_; }
  const std::string& path() const { return path_; }

  /// Where the file really is: symbolic links followed.
  const std::string& location() const { return location_; }

private:
  [[noreturn]] void fail(const std::string& why) const;
  bool place();
  void takeBack();
  void release();
  void forget();

  std::string option_;
  std::string path_;
  std::string location_;
  std::string temporary_; ///< empty while there is none; once placed, of what was there before
  bool overwrite_;
  bool is_new_ = false; ///< once placed: nothing was there before
};

/// \param files null ones are none
/// \throws Failure (Usage) where two are the same
void requireDistinct(const std::vector<OutputFile*>& files);

/// Writes it all to an open file.
/// \return false, and errno, where that was not possible
bool writeAll(int file, std::string_view content);

/// Puts on the disk what was written.
/// \return false, and errno, where that was not possible
bool synchronised(int file);

/// \throws Failure (Output) when the text does not get there
void writeToStandardOutput(std::string_view text);

} // namespace pcl_gpu_icp::cli
