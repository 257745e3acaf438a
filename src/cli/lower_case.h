#pragma once

#include <algorithm>
#include <cctype>
#include <string>

namespace pcl_gpu_icp::cli {

inline std::string inLowerCase(std::string text)
{
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

} // namespace pcl_gpu_icp::cli
