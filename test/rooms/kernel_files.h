#pragma once

#include "embedded_kernels.h"

#include <string>
#include <vector>

namespace pcl_gpu_icp::test {

/// The files that programs are made of: all that are embedded but the headers.
inline std::vector<std::string> kernelFiles()
{
  std::vector<std::string> files;
  for (const opencl::EmbeddedFile& kernel : opencl::embedded_files) {
    const std::string file = kernel.name;
    if (file.size() > 3 && file.compare(file.size() - 3, 3, ".cl") == 0)
      files.push_back(file);
  }
  return files;
}

} // namespace pcl_gpu_icp::test
