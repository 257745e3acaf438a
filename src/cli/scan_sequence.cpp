#include "cli/scan_sequence.h"

#include "cli/failure.h"

#include <algorithm>
#include <glob.h>
#include <string_view>

namespace pcl_gpu_icp::cli {
namespace {

std::vector<std::string> matches(const std::string& pattern)
{
  glob_t found{};
  const int error = glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found);
  std::vector<std::string> files(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  globfree(&found);
  if (error != 0 && error != GLOB_NOMATCH)
    throw Failure(ExitCode::Input, "--sequence " + pattern + ": cannot be looked for");
  return files;
}

bool isDigit(char c) { return c >= '0' && c <= '9'; }

/// Takes a number off the front, without its leading zeros.
std::string_view nextNumber(std::string_view& text)
{
  const auto end = std::find_if_not(text.begin(), text.end(), isDigit);
  const auto length = static_cast<std::size_t>(end - text.begin());
  std::string_view digits = text.substr(0, length);
  text.remove_prefix(length);
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  return digits;
}

/// Whether a is before b where numbers are compared as numbers.
bool isBefore(const std::string& a, const std::string& b)
{
  std::string_view x(a), y(b);
  while (!x.empty() && !y.empty()) {
    if (isDigit(x.front()) && isDigit(y.front())) {
      const std::string_view m = nextNumber(x), n = nextNumber(y);
      if (m != n)
        return m.size() != n.size() ? m.size() < n.size() : m < n;
      continue;
    }
    if (x.front() != y.front())
      return x.front() < y.front();
    x.remove_prefix(1);
    y.remove_prefix(1);
  }
  return x.size() != y.size() ? x.empty() : a < b;
}

} // namespace

std::vector<ListedPair> listSequence(const std::string& pattern, const OptionTexts& options)
{
  std::vector<std::string> scans = matches(pattern);
  if (scans.size() < 2)
    throw Failure(ExitCode::Input,
                  "--sequence " + pattern + ": matches " + (scans.empty() ? "no file" : "only " + scans.front()) +
                      ", and a sequence has two or more");
  std::sort(scans.begin(), scans.end(), isBefore);
  AlignmentOptions alignment = PairOptions().parse(options);
  std::vector<ListedPair> pairs;
  for (std::size_t i = 0; i + 1 < scans.size(); ++i) {
    alignment.source = scans[i + 1];
    alignment.target = scans[i];
    pairs.push_back({{i, scans[i + 1], scans[i], options}, alignment});
  }
  return pairs;
}

} // namespace pcl_gpu_icp::cli
