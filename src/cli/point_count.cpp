#include "cli/point_count.h"

#include "cli/input_file.h"
#include "cli/number.h"

namespace pcl_gpu_icp::cli {
namespace {

constexpr std::size_t longest_header = 4096; // bytes

} // namespace

std::size_t pointsInHeader(const std::string& path)
{
  std::string start;
  try {
    start = readFile(path, longest_header);
  } catch (const Failure&) {
    return 0; // whoever reads the file finds out why
  }
  std::string_view rest(start);
  while (!rest.empty()) {
    std::string_view line = nextLine(rest);
    const std::string_view first = nextWord(line);
    if (first == "DATA" || first == "end_header")
      break;
    if (first == "POINTS" || (first == "element" && nextWord(line) == "vertex"))
      return parseNumber<std::size_t>(nextWord(line)).value_or(0);
  }
  return 0;
}

} // namespace pcl_gpu_icp::cli
