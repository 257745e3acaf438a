#pragma once

#include <map>
#include <string>

namespace pcl_gpu_icp::opencl {

/// Time the device spent, by what it was spent on, as its own event timers measured it.
struct Profile {
  struct Entry {
    double milliseconds = 0;
    unsigned count = 0; ///< commands timed
  };
  std::map<std::string, Entry> entries;

  void add(const std::string& what, double milliseconds)
  {
    Entry& entry = entries[what];
    entry.milliseconds += milliseconds;
    ++entry.count;
  }
};

} // namespace pcl_gpu_icp::opencl
