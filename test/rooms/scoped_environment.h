#pragma once

#include <cstdlib>
#include <optional>
#include <string>

namespace pcl_gpu_icp::test {

/// Sets an environment variable until the end of the scope.
class ScopedEnvironment {
public:
  ScopedEnvironment(const char* name, const std::string& value)
  : name_(name)
  {
    if (const char* before = std::getenv(name))
      before_ = before;
    setenv(name, value.c_str(), 1);
  }
  ~ScopedEnvironment()
  {
    if (before_)
      setenv(name_, before_->c_str(), 1);
    else
      unsetenv(name_);
  }
  ScopedEnvironment(const ScopedEnvironment&) = delete;
  ScopedEnvironment& operator=(const ScopedEnvironment&) = delete;

private:
  const char* name_;
  std::optional<std::string> before_;
};

} // namespace pcl_gpu_icp::test
