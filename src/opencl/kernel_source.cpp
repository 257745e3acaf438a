#include "kernel_source.h"

#include "embedded_kernels.h"

#include <pcl_gpu_icp/error.h>

#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

namespace pcl_gpu_icp::opencl {

namespace {

std::string rawText(const std::string& file)
{
  const char* directory = std::getenv("PCL_GPU_ICP_KERNEL_DIR");
  if (directory && *directory) {
    const std::string path = std::string(directory) + "/" + file;
    std::ifstream stream(path);
    if (!stream)
      throw InvalidArgument("cannot read kernel file " + path + " (PCL_GPU_ICP_KERNEL_DIR is set)");
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  for (const EmbeddedFile& kernel : embedded_files)
    if (file == kernel.name)
      return kernel.text;
  throw InvalidArgument("no kernel file " + file + " was embedded");
}

void append(const std::string& file, std::set<std::string>& included, std::string& source)
{
  if (!included.insert(file).second)
    return;
  source += "#line 1 \"" + file + "\"\n";
  std::istringstream text(rawText(file));
  std::string line;
  for (unsigned number = 1; std::getline(text, line); ++number) {
    const std::string directive = "#include \"";
    if (line.compare(0, directive.size(), directive) == 0) {
      append(line.substr(directive.size(), line.find('"', directive.size()) - directive.size()), included, source);
      source += "#line " + std::to_string(number + 1) + " \"" + file + "\"\n";
    }
    else
      source += line + "\n";
  }
}

} // namespace

std::string kernelSource(const std::string& file)
{
  std::set<std::string> included;
  std::string source;
  append(file, included, source);
  return source;
}

} // namespace pcl_gpu_icp::opencl
