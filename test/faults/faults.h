#pragma once

#include <cstddef>
#include <map>
#include <string>

/// Makes one call of a function fail. The functions of OpenCL that the library imports and those of the system that the
/// command writes files with are defined here, in front of the real ones; those of the system fail where the program
/// itself calls them, not its libraries.
namespace faults {

constexpr int writes_half = -1; ///< write() writes half of what it is given, which is no failure

struct Fault {
  std::string function; ///< "allocate" stands for malloc() and operator new
  unsigned long call = 1;
  int code = 0;                      ///< OpenCL's, or errno
  std::size_t smallest_bytes = 2048; ///< of allocations that count
};

/// Allocations that count have at least so many.
std::size_t smallestBytes();

/// Counts anew from here; the fault happens once.
void arm(const Fault& fault);
void disarm();

/// Calls of each function since then.
std::map<std::string, unsigned long> calls();

/// OpenCL objects created or retained and not released, by kind, since the start of the process.
std::map<std::string, long> live();

} // namespace faults
