#include "cli/output_file.h"

#include "cli/failure.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <mutex>
#include <set>
#include <sys/stat.h>
#include <unistd.h>

namespace pcl_gpu_icp::cli {
namespace {

namespace fs = std::filesystem;

std::string lastError() { return std::strerror(errno); }

/// Follows symbolic links, also to a file that is not there yet, which weakly_canonical() leaves alone.
fs::path resolved(fs::path path, std::error_code& error)
{
  path = fs::absolute(path, error);
  constexpr int most_links = 40;
  for (int i = 0; i < most_links && fs::is_symlink(fs::symlink_status(path, error)); ++i)
    path = path.parent_path() / fs::read_symlink(path, error);
  return fs::weakly_canonical(path, error);
}

/// \param flags of renameat2, which not every file system has: `instead` is called there
template <typename Instead>
bool renamed(const std::string& from, const std::string& to, unsigned flags, const Instead& instead)
{
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), flags) == 0)
    return true;
  return (errno == EINVAL || errno == ENOSYS) && instead();
}

bool renamed(const std::string& from, const std::string& to) { return rename(from.c_str(), to.c_str()) == 0; }

bool exchanged(const std::string& from, const std::string& to)
{
  return renamed(from, to, RENAME_EXCHANGE, [&] { return renamed(from, to); });
}

bool renamedToNone(const std::string& from, const std::string& to)
{
  return renamed(from, to, RENAME_NOREPLACE, [&] {
    if (access(to.c_str(), F_OK) != 0)
      return renamed(from, to);
    errno = EEXIST;
    return false;
  });
}

/// The names of the temporary files that there are.
struct Temporaries {
  std::mutex mutex;
  std::set<std::string> names;
};
Temporaries& temporaries()
{
  static auto& all = *new Temporaries; // a signal may end the process while static objects are destroyed
  return all;
}

mode_t defaultMode()
{
  const mode_t mask = umask(0);
  umask(mask);
  return 0666 & ~mask;
}

} // namespace

OutputFile::OutputFile(std::string option, const std::string& path, bool overwrite)
: option_(std::move(option))
, path_(path)
, overwrite_(overwrite)
{
  std::error_code error;
  const fs::path location = resolved(path_, error);
  if (error)
    fail(error.message());
  location_ = location.string();
  const fs::path directory = location.parent_path();
  if (!fs::is_directory(directory, error))
    fail("there is no directory " + directory.string());
  const fs::file_status status = fs::symlink_status(location, error);
  if (fs::exists(status)) {
    if (!fs::is_regular_file(status))
      fail("exists and is not a regular file");
    if (!overwrite_)
      fail("exists; --force overwrites it");
    if (access(location_.c_str(), W_OK) != 0)
      fail(lastError());
  }
  if (access(directory.c_str(), W_OK | X_OK) != 0)
    fail("directory " + directory.string() + ": " + lastError());
}

OutputFile::~OutputFile()
{
  if (temporary_.empty())
    return;
  const std::lock_guard<std::mutex> lock(temporaries().mutex);
  unlink(temporary_.c_str());
  temporaries().names.erase(temporary_);
}

void OutputFile::endAll()
{
  temporaries().mutex.lock(); // for good
  for (const std::string& name : temporaries().names)
    unlink(name.c_str());
}

void OutputFile::fail(const std::string& why) const
{
  throw Failure(ExitCode::Output, option_ + " " + path_ + ": " + why);
}

void OutputFile::write(std::string_view content)
{
  const fs::path location(location_);
  std::string name = (location.parent_path() / ".pcl_gpu_icp.XXXXXX").string();
  int file = -1;
  {
    const std::lock_guard<std::mutex> lock(temporaries().mutex);
    file = mkstemp(name.data());
    if (file < 0)
      fail(lastError());
    temporaries().names.insert(name);
    temporary_ = name;
  }
  struct stat existing;
  const mode_t mode = stat(location_.c_str(), &existing) == 0 ? existing.st_mode & 07777 : defaultMode();
  const bool written = writeAll(file, content) && fchmod(file, mode) == 0 && synchronised(file);
  const std::string error = lastError();
  // A close that is interrupted has closed the file, and all is on the disk.
  const bool closed = close(file) == 0 || errno == EINTR;
  if (!closed || !written)
    fail(written ? lastError() : error);
}

void OutputFile::commit(const std::vector<OutputFile*>& files)
{
  const std::lock_guard<std::mutex> lock(temporaries().mutex); // a signal finds all of them or none
  std::vector<OutputFile*> placed;
  for (OutputFile* file : files) {
    if (!file)
      continue;
    if (!file->place()) {
      const std::string why = errno == EEXIST ? "appeared meanwhile; --force overwrites it" : lastError();
      for (OutputFile* before : placed)
        before->takeBack();
      file->fail(why);
    }
    placed.push_back(file);
  }
  for (OutputFile* file : placed)
    file->release();
}

bool OutputFile::place()
{
  is_new_ = !overwrite_ || access(location_.c_str(), F_OK) != 0;
  if (!overwrite_)
    return renamedToNone(temporary_, location_);
  return is_new_ ? renamed(temporary_, location_) : exchanged(temporary_, location_);
}

void OutputFile::takeBack()
{
  if (is_new_)
    renamed(location_, temporary_);
  else if (access(temporary_.c_str(), F_OK) == 0 && !exchanged(temporary_, location_))
    forget(); // what it has is what was there before
}

void OutputFile::release()
{
  unlink(temporary_.c_str());
  forget();
}

void OutputFile::forget()
{
  temporaries().names.erase(temporary_);
  temporary_.clear();
}

void requireDistinct(const std::vector<OutputFile*>& files)
{
  for (auto a = files.begin(); a != files.end(); ++a)
    for (auto b = a + 1; b != files.end(); ++b)
      if (*a && *b && (*a)->location() == (*b)->location())
        throw Failure(ExitCode::Usage,
                      (*a)->option() + " and " + (*b)->option() + " are the same file, " + (*a)->path());
}

bool writeAll(int file, std::string_view content)
{
  while (!content.empty()) {
    const ssize_t written = ::write(file, content.data(), content.size());
    if (written < 0 && errno == EINTR)
      continue;
    if (written < 0)
      return false;
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

bool synchronised(int file)
{
  int result;
  do
    result = fsync(file);
  while (result != 0 && errno == EINTR);
  return result == 0;
}

void writeToStandardOutput(std::string_view text)
{
  if (!writeAll(STDOUT_FILENO, text))
    throw Failure(ExitCode::Output, "standard output: " + lastError());
}

} // namespace pcl_gpu_icp::cli
