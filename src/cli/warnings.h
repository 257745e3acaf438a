#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace pcl_gpu_icp::cli {

/// Lines that say what of the files may not be as meant, each naming its file. They are part of the result, too.
using Warnings = std::vector<std::string>;

inline void append(Warnings& to, const Warnings& more) { to.insert(to.end(), more.begin(), more.end()); }

/// A line each on standard error.
inline void print(const Warnings& warnings)
{
  for (std::string line : warnings) {
    for (char& character : line)
      if (character == '\n')
        character = ' ';
    std::fprintf(stderr, "pcl_gpu_icp: warning: %s\n", line.c_str());
  }
}

} // namespace pcl_gpu_icp::cli
