#include "report/format.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace pcl_gpu_icp::report {

std::string format(const char* pattern, ...)
{
  va_list arguments;
  va_start(arguments, pattern);
  va_list measured;
  va_copy(measured, arguments);
  std::string text(std::vsnprintf(nullptr, 0, pattern, measured), '\0');
  va_end(measured);
  std::vsnprintf(text.data(), text.size() + 1, pattern, arguments);
  va_end(arguments);
  return text;
}

std::string counted(std::size_t count, const char* what)
{
  return format("%zu %s%s", count, what, count == 1 ? "" : "s");
}

std::string directionText(const char* how, const std::array<double, 3>& direction)
{
  // Without the sign of a zero.
  const auto entry = [&direction](int i) { return std::round(100 * direction[i]) / 100 + 0.0; };
  return format("%s (%.2g, %.2g, %.2g)", how, entry(0), entry(1), entry(2));
}

} // namespace pcl_gpu_icp::report
