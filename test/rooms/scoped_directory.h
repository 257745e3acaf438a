#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

namespace pcl_gpu_icp::test {

/// An empty directory that is removed with all it holds at the end of the scope.
class ScopedDirectory {
public:
  ScopedDirectory()
  {
    std::string pattern = (std::filesystem::temp_directory_path() / "pcl_gpu_icp_test_XXXXXX").string();
    if (!mkdtemp(pattern.data()))
      throw std::runtime_error("cannot create " + pattern);
    path_ = pattern;
  }
  ~ScopedDirectory()
  {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScopedDirectory(const ScopedDirectory&) = delete;
  ScopedDirectory& operator=(const ScopedDirectory&) = delete;

  std::string path() const { return path_.string(); }

  void write(const std::string& file, const std::string& text) const { std::ofstream(path_ / file) << text; }

private:
  std::filesystem::path path_;
};

} // namespace pcl_gpu_icp::test
