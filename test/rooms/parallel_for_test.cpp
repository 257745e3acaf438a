// parallelFor: every index once, from any number of threads.
#include <pcl_gpu_icp/parallel_for.h>

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace pcl_gpu_icp::test {

TEST(ParallelFor, CoversEveryIndexOnce)
{
  for (const std::size_t count : {0, 1, 511, 512, 513, 5000})
    for (const unsigned threads : {0, 1, 2, 7}) {
      std::vector<std::atomic<int>> visits(count);
      parallelFor(count, 512, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
          ++visits[i];
      });
      for (std::size_t i = 0; i < count; ++i)
        ASSERT_EQ(visits[i], 1) << i << " of " << count;
    }
}

TEST(ParallelFor, RethrowsWhatABodyThrows)
{
  for (const unsigned threads : {1, 4})
    EXPECT_THROW(parallelFor(10'000,
                             512,
                             threads,
                             [](std::size_t begin, std::size_t) {
                               if (begin > 4000)
                                 throw std::runtime_error("from a body");
                             }),
                 std::runtime_error);
}

} // namespace pcl_gpu_icp::test
