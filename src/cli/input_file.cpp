#include "cli/input_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace pcl_gpu_icp::cli {

Failure inputFailure(const std::string& path, const std::string& why)
{
  constexpr std::size_t longest = 500; // bytes; what is quoted from a file may be as long as the file
  return Failure(ExitCode::Input, path + ": " + (why.size() > longest ? why.substr(0, longest) + "..." : why));
}

std::string shellWord(const std::string& text)
{
  const bool plain = !text.empty() && text.front() != '-' && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) || std::strchr("/._-+,:@%", c) || c >= 0x80;
  });
  if (plain)
    return text;
  std::string quoted = "'";
  for (const char c : text)
    quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string readFile(const std::string& path, std::size_t most)
{
  // Without O_NONBLOCK opening a pipe would wait for its writer.
  const int file = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0)
    throw inputFailure(path, std::strerror(errno));
  struct Closer {
    int file;
    ~Closer() { close(file); }
  } closer{file};
  struct stat status;
  if (fstat(file, &status) != 0)
    throw inputFailure(path, std::strerror(errno));
  if (!S_ISREG(status.st_mode))
    throw inputFailure(path, S_ISDIR(status.st_mode) ? "is a directory" : "is not a regular file");

  std::string content(std::min(static_cast<std::size_t>(status.st_size), most), '\0');
  std::size_t filled = 0;
  while (filled < content.size()) {
    const ssize_t count = read(file, content.data() + filled, content.size() - filled);
    if (count < 0 && errno == EINTR)
      continue;
    if (count < 0)
      throw inputFailure(path, std::strerror(errno));
    if (count == 0)
      break;
    filled += static_cast<std::size_t>(count);
  }
  content.resize(filled);
  return content;
}

std::string filtered(const std::string& filter, const std::string& path)
{
  return path == standard_input ? filter : filter + " < " + shellWord(path) + " > NEW";
}

std::string readStandardInput()
{
  std::string content;
  std::array<char, 1 << 16> part;
  for (;;) {
    const ssize_t count = read(STDIN_FILENO, part.data(), part.size());
    if (count < 0 && errno == EINTR)
      continue;
    if (count < 0)
      throw inputFailure(std::string(standard_input), std::strerror(errno));
    if (count == 0)
      return content;
    content.append(part.data(), static_cast<std::size_t>(count));
  }
}

bool looksBinary(std::string_view content)
{
  constexpr std::size_t start = 4096; // bytes
  return content.substr(0, start).find('\0') != std::string_view::npos;
}

} // namespace pcl_gpu_icp::cli
