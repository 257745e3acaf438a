#include "cli/nearest_name.h"

#include "cli/lower_case.h"

#include <algorithm>
#include <numeric>

namespace pcl_gpu_icp::cli {
namespace {

constexpr std::size_t longest = 64; // what is longer is no slip of the keys

/// The fewest letters to replace, leave out, put in or swap with their neighbours.
std::size_t distance(const std::string& a, const std::string& b)
{
  std::vector<std::size_t> before, last(b.size() + 1), row(b.size() + 1); // of prefixes of a to each prefix of b
  std::iota(last.begin(), last.end(), std::size_t(0));
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before = last;
    last = row;
  }
  return last.back();
}

} // namespace

std::string proposal(const std::string& name) { return "; did you mean " + name + "?"; }

std::string didYouMean(const std::string& mistyped, const std::vector<std::string>& names)
{
  const std::string word = lowerCase(mistyped);
  if (word.size() > longest)
    return "";
  const std::string* nearest = nullptr;
  std::size_t least = longest;
  for (const std::string& name : names) {
    const std::size_t letters = std::max(word.size(), name.size()) - std::min(name.find_first_not_of('-'), name.size());
    const std::size_t apart = distance(word, name);
    if (apart <= letters / 3 && apart < least) {
      nearest = &name;
      least = apart;
    }
  }
  return nearest ? proposal(*nearest) : "";
}

} // namespace pcl_gpu_icp::cli
