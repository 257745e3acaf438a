// Put in front of a command by LD_PRELOAD: PCL_GPU_ICP_FAULT is FUNCTION:CALL:CODE, and PCL_GPU_ICP_FAULT_REPORT the
// file that gets the number of calls of each function and of each kind of object that is left when the process ends.
#include "faults.h"

#include <cstdio>
#include <cstdlib>
#include <sstream>

namespace {

__attribute__((constructor)) void begin()
{
  faults::Fault fault;
  if (const char* text = std::getenv("PCL_GPU_ICP_FAULT")) {
    std::istringstream words(text);
    std::string number;
    std::getline(words, fault.function, ':');
    std::getline(words, number, ':');
    fault.call = std::strtoul(number.c_str(), nullptr, 10);
    words >> fault.code;
  }
  faults::arm(fault);
}

__attribute__((destructor)) void report()
{
  const char* path = std::getenv("PCL_GPU_ICP_FAULT_REPORT");
  std::FILE* file = path ? std::fopen(path, "w") : nullptr;
  if (!file)
    return;
  for (const auto& [function, count] : faults::calls())
    std::fprintf(file, "calls %s %lu\n", function.c_str(), count);
  for (const auto& [kind, count] : faults::live())
    std::fprintf(file, "left %s %ld\n", kind.c_str(), count);
  std::fclose(file);
}

} // namespace
