#include "kernel_cache.h"

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace pcl_gpu_icp::opencl {

namespace {

namespace fs = std::filesystem;

// More than all kernels take, and than the largest file of one. PoCL's compiler ends the process where it cannot write.
constexpr std::uint64_t needed_room = 4 << 20;
constexpr rlim_t needed_file_size = 1 << 20;

const char* variable(const char* name)
{
  const char* value = std::getenv(name);
  return value && *value ? value : nullptr;
}

/// What keeps PoCL from making and filling the folder; empty: nothing.
std::string obstacleTo(const fs::path& folder)
{
  std::error_code error;
  fs::path existing = fs::absolute(folder, error);
  while (!fs::exists(existing, error) && existing.has_relative_path())
    existing = existing.parent_path();
  if (!fs::is_directory(existing, error))
    return std::strerror(ENOTDIR);
  if (access(existing.c_str(), W_OK | X_OK) != 0)
    return std::strerror(errno);
  struct statvfs system;
  if (statvfs(existing.c_str(), &system) == 0 &&
      static_cast<std::uint64_t>(system.f_bavail) * system.f_frsize < needed_room)
    return std::strerror(ENOSPC);
  struct rlimit limit;
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur < needed_file_size)
    return std::string(std::strerror(EFBIG)) + " (ulimit -f)";
  return "";
}

std::string explained(const std::string& folder, const std::string& obstacle)
{
  return "PoCL cannot keep its kernels in " + folder + ": " + obstacle;
}

/// Only what this user alone can write is safe to run code from.
bool isPrivate(const fs::path& folder)
{
  struct stat status;
  return lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == geteuid() &&
         (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

} // namespace

KernelCache chooseKernelCache()
{
  constexpr const char* advice = "; set POCL_CACHE_DIR to a folder that can be written and has room";
  const auto usersOwn = [&](const fs::path& folder, const char* name) {
    const std::string obstacle = obstacleTo(folder);
    return KernelCache{
        folder.string(),
        obstacle.empty() ? "" : explained(folder.string() + ", which " + name + " asks for", obstacle) + advice};
  };
  const char* caching = variable("POCL_KERNEL_CACHE");
  const fs::path below = fs::path("pocl") / (caching && std::strcmp(caching, "0") == 0 ? "uncached" : "kcache");
  if (const char* folder = variable("POCL_CACHE_DIR"))
    return usersOwn(folder, "POCL_CACHE_DIR");
  if (const char* folder = variable("XDG_CACHE_HOME"))
    return usersOwn(folder / below, "XDG_CACHE_HOME");

  std::string why_not_home = "HOME is not set";
  if (const char* home = variable("HOME")) {
    const fs::path folder = fs::path(home) / ".cache" / below;
    const std::string obstacle = obstacleTo(folder);
    if (obstacle.empty())
      return {folder.string(), ""};
    why_not_home = explained(folder.string(), obstacle);
  }
  std::error_code error;
  const fs::path temporary = fs::temp_directory_path(error);
  const fs::path folder = (error ? "/tmp" : temporary) / ("pcl_gpu_icp-" + std::to_string(geteuid()));
  mkdir(folder.c_str(), S_IRWXU);
  std::string obstacle = obstacleTo(folder);
  if (obstacle.empty() && !isPrivate(folder))
    obstacle = "it belongs to others";
  return {folder.string(),
          obstacle.empty() ? "" : why_not_home + "; nor in " + folder.string() + ": " + obstacle + advice,
          true};
}

const KernelCache& kernelCache()
{
  static const KernelCache& cache = *new KernelCache([] {
    KernelCache choice = chooseKernelCache();
    if (choice.is_ours && choice.obstacle.empty())
      setenv("POCL_CACHE_DIR", choice.directory.c_str(), 1);
    return choice;
  }());
  return cache;
}

} // namespace pcl_gpu_icp::opencl
