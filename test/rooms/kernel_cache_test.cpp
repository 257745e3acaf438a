// Where PoCL keeps its kernels: what the user says, or a place that can be written.
#include "opencl/kernel_cache.h"

#include "scoped_directory.h"
#include "scoped_environment.h"

#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <sys/resource.h>
#include <unistd.h>

namespace pcl_gpu_icp::test {

using opencl::chooseKernelCache;
using opencl::KernelCache;

namespace fs = std::filesystem;

namespace {

// For root, too, nothing can be made below a file.
constexpr const char* unusable = "/dev/null/home";

void expectObstacle(const KernelCache& cache, const std::string& folder, const std::string& named)
{
  EXPECT_NE(cache.obstacle.find(folder), std::string::npos) << cache.obstacle;
  EXPECT_NE(cache.obstacle.find(named), std::string::npos) << cache.obstacle;
  EXPECT_NE(cache.obstacle.find("set POCL_CACHE_DIR to a folder"), std::string::npos) << cache.obstacle;
}

} // namespace

class KernelCacheChoice : public testing::Test {
protected:
  ScopedDirectory directory_;
  // Empty ones are as good as none.
  ScopedEnvironment pocl_{"POCL_CACHE_DIR", ""}, xdg_{"XDG_CACHE_HOME", ""}, caching_{"POCL_KERNEL_CACHE", ""};
  ScopedEnvironment home_{"HOME", directory_.path()}, temporary_{"TMPDIR", directory_.path()};
  const std::string private_ = directory_.path() + "/pcl_gpu_icp-" + std::to_string(geteuid());
};

TEST_F(KernelCacheChoice, IsPoclsOwnWhereThatCanBeWritten)
{
  const KernelCache cache = chooseKernelCache();
  EXPECT_EQ(cache.directory, directory_.path() + "/.cache/pocl/kcache");
  EXPECT_EQ(cache.obstacle, "");
  EXPECT_FALSE(cache.is_ours);
  EXPECT_TRUE(fs::is_empty(directory_.path())) << "PoCL makes it, not we";
  const ScopedEnvironment uncached("POCL_KERNEL_CACHE", "0");
  EXPECT_EQ(chooseKernelCache().directory, directory_.path() + "/.cache/pocl/uncached");
}

TEST_F(KernelCacheChoice, WithoutAHomeIsAFolderOfThisUserAlone)
{
  for (const char* home : {unusable, ""}) {
    const ScopedEnvironment environment("HOME", home);
    const KernelCache cache = chooseKernelCache();
    EXPECT_EQ(cache.directory, private_);
    EXPECT_EQ(cache.obstacle, "");
    EXPECT_TRUE(cache.is_ours);
    EXPECT_EQ(fs::status(private_).permissions(), fs::perms::owner_all);
  }
}

TEST_F(KernelCacheChoice, NeverIsAFolderThatOthersCanWrite)
{
  const ScopedEnvironment environment("HOME", unusable);
  fs::create_directory(private_);
  fs::permissions(private_, fs::perms::all);
  expectObstacle(chooseKernelCache(), private_, unusable);
  fs::remove(private_);
  const ScopedDirectory elsewhere;
  fs::create_directory_symlink(elsewhere.path(), private_);
  expectObstacle(chooseKernelCache(), private_, unusable);
}

TEST_F(KernelCacheChoice, WhereNothingCanBeWrittenSaysWhatToDo)
{
  const ScopedEnvironment home("HOME", unusable);
  directory_.write("file", "");
  fs::create_directory(directory_.path() + "/folder");
  directory_.write("folder/pcl_gpu_icp-" + std::to_string(geteuid()), "a file in the place of the folder");
  const ScopedEnvironment temporary("TMPDIR", directory_.path() + "/folder");
  expectObstacle(chooseKernelCache(), directory_.path() + "/folder", unusable);
}

TEST_F(KernelCacheChoice, WhatTheUserSaysIsKeptAndNamedWhereItIsOfNoUse)
{
  {
    const ScopedEnvironment xdg("XDG_CACHE_HOME", directory_.path() + "/xdg");
    EXPECT_EQ(chooseKernelCache().directory, directory_.path() + "/xdg/pocl/kcache");
    EXPECT_EQ(chooseKernelCache().obstacle, "");
    const ScopedEnvironment pocl("POCL_CACHE_DIR", directory_.path() + "/mine");
    EXPECT_EQ(chooseKernelCache().directory, directory_.path() + "/mine");
    EXPECT_EQ(chooseKernelCache().obstacle, "");
  }
  const ScopedEnvironment xdg("XDG_CACHE_HOME", "/dev/null/xdg");
  expectObstacle(chooseKernelCache(), "/dev/null/xdg/pocl/kcache", "XDG_CACHE_HOME");
  const ScopedEnvironment pocl("POCL_CACHE_DIR", "/dev/null/mine");
  expectObstacle(chooseKernelCache(), "/dev/null/mine", "POCL_CACHE_DIR asks for");
  EXPECT_FALSE(chooseKernelCache().is_ours);
}

TEST_F(KernelCacheChoice, AFileSizeLimitThatKernelsExceedIsAnObstacle)
{
  const ScopedEnvironment pocl("POCL_CACHE_DIR", directory_.path() + "/mine");
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit low = {4096, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &low);
  const KernelCache cache = chooseKernelCache();
  setrlimit(RLIMIT_FSIZE, &before);
  expectObstacle(cache, directory_.path() + "/mine", "ulimit -f");
}

} // namespace pcl_gpu_icp::test
