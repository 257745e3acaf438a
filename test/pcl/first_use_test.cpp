// The first use of OpenCL in a process, by many threads at once, as an OpenMP loop over hypotheses makes it.
#include "../rooms/scoped_directory.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace pcl_gpu_icp::test {

namespace {

/// Runs first_use in a process of its own, with the kernels that an earlier process left in `cache`.
/// Debian's loader starts every implementation itself where there are several, but not where there is one alone.
int statusOf(const ScopedDirectory& cache, int threads, const std::string& what)
{
  const std::string command = "OCL_ICD_VENDORS=/etc/OpenCL/vendors/pocl.icd POCL_CACHE_DIR='" + cache.path() +
                              "' '" FIRST_USE "' " + std::to_string(threads) + ' ' + what;
  return std::system(command.c_str());
}

} // namespace

class FirstUse : public testing::TestWithParam<std::string> {};

// The first process finds no kernels, the next those that it left.
TEST_P(FirstUse, ByManyThreadsAtOnce)
{
  const ScopedDirectory cache;
  for (const int threads : {8, 2, 8, 64})
    EXPECT_EQ(statusOf(cache, threads, GetParam()), 0) << threads << " threads";
}

INSTANTIATE_TEST_SUITE_P(,
                         FirstUse,
                         testing::Values("pcl", "device", "batch", "estimator", "partition"),
                         [](const auto& info) { return info.param; });

TEST(FirstUseWithoutKernels, ByTwoThreadsAndByVeryMany)
{
  for (const int threads : {2, 64}) {
    const ScopedDirectory cache;
    EXPECT_EQ(statusOf(cache, threads, "device"), 0) << threads << " threads";
  }
}

} // namespace pcl_gpu_icp::test
