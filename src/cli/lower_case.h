#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace pcl_gpu_icp::cli {

inline std::string lowerCase(std::string_view spelled)
{
  std::string text(spelled);
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

} // namespace pcl_gpu_icp::cli
