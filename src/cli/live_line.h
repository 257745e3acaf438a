#pragma once

#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>
#include <unistd.h>

namespace pcl_gpu_icp::cli {

/// Whether it is a terminal whose reader has not asked for none (https://no-color.org).
inline bool isColoured(int descriptor)
{
  const char* no_colour = std::getenv("NO_COLOR");
  return isatty(descriptor) && !(no_colour && *no_colour);
}

/// A line on the terminal that is renewed again and again, and gone in the end. Where stderr is no terminal there is
/// none. Thread-safe.
class LiveLine {
public:
  explicit LiveLine(bool wanted)
  : shown_(wanted && isatty(STDERR_FILENO))
  {
  }
  ~LiveLine() { clear(); }
  LiveLine(const LiveLine&) = delete;
  LiveLine& operator=(const LiveLine&) = delete;

  bool isShown() const { return shown_; }
  void show(const std::string& text)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    text_ = text;
    print(text);
  }
  void clear() { show(""); }

  /// Shows another text until it is uncovered or renewed.
  void cover(const std::string& text)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    print(text);
  }
  void uncover()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    print(text_);
  }

private:
  void print(const std::string& text)
  {
    if (shown_)
      std::fprintf(stderr, "\r%s\033[K", text.c_str());
  }

  const bool shown_;
  std::mutex mutex_;
  std::string text_;
};

} // namespace pcl_gpu_icp::cli
