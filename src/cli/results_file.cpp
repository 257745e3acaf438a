#include "cli/results_file.h"

#include "cli/input_file.h"
#include "cli/output_file.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace pcl_gpu_icp::cli {

ResultsFile::ResultsFile(const std::string& path, Existing existing)
: path_(path)
{
  // Without O_NONBLOCK opening a pipe would wait for its reader.
  file_ = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0666);
  if (file_ < 0)
    fail(std::strerror(errno));
  try {
    open(existing);
  } catch (...) {
    close(file_);
    throw;
  }
}

Failure ResultsFile::refusal(const std::string& path)
{
  return Failure(ExitCode::Output, path + ": exists; --resume goes on with it, --force starts anew");
}

ResultsFile::~ResultsFile() { close(file_); }

void ResultsFile::open(Existing existing)
{
  const bool is_held = flock(file_, LOCK_EX | LOCK_NB) == 0;
  const int not_held = errno;
  struct stat status;
  if (fstat(file_, &status) != 0)
    fail(std::strerror(errno));
  if (!S_ISREG(status.st_mode))
    fail("exists and is not a regular file");
  if (!is_held)
    fail(not_held == EWOULDBLOCK ? "another process is writing it" : std::strerror(not_held));
  if (existing == Existing::Refused && status.st_size > 0)
    throw refusal(path_);
  if (existing == Existing::Continued) {
    kept_ = readFile(path_);
    kept_.resize(kept_.rfind('\n') + 1); // npos + 1 is 0
  }
  size_ = kept_.size();
  if (ftruncate(file_, static_cast<off_t>(size_)) != 0)
    fail(std::strerror(errno));
}

void ResultsFile::append(std::string_view line)
{
  if (writeAll(file_, line) && synchronised(file_)) {
    size_ += line.size();
    return;
  }
  const std::string why = std::strerror(errno);
  if (ftruncate(file_, static_cast<off_t>(size_)) != 0)
    fail(why + "; and its last line is not whole: " + std::strerror(errno));
  fail(why);
}

void ResultsFile::fail(const std::string& why) const { throw Failure(ExitCode::Output, path_ + ": " + why); }

} // namespace pcl_gpu_icp::cli
