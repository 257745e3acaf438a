// SharedCache: what one made, all have, as long as somebody does.
#include <pcl_gpu_icp/search/shared_cache.h>

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace pcl_gpu_icp::test {

using Cache = search::SharedCache<std::string>;
using Value = std::shared_ptr<const std::string>;

TEST(SharedCache, AValueLivesWhileSomebodyHoldsIt)
{
  Cache cache;
  int made = 0;
  const auto make = [&] {
    ++made;
    return std::make_shared<const std::string>("value");
  };
  Value first = cache.get(1, make);
  Value second = cache.get(1, make);
  EXPECT_EQ(first, second);
  EXPECT_EQ(made, 1);
  const Value other = cache.get(2, make);
  EXPECT_NE(other, first);
  EXPECT_EQ(made, 2);
  const std::weak_ptr<const std::string> watched = first;
  first.reset();
  second.reset();
  EXPECT_TRUE(watched.expired());
  first = cache.get(1, make);
  EXPECT_EQ(made, 3);
}

TEST(SharedCache, AFailureIsNotKept)
{
  Cache cache;
  EXPECT_THROW(cache.get(1, []() -> Value { throw std::runtime_error("no"); }), std::runtime_error);
  EXPECT_EQ(*cache.get(1, [] { return std::make_shared<const std::string>("yes"); }), "yes");
}

TEST(SharedCache, ManyThreadsMakeAValueOnce)
{
  for (int round = 0; round < 50; ++round) {
    Cache cache;
    std::atomic<int> made{0};
    std::vector<Value> values(8);
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < values.size(); ++i)
      threads.emplace_back([&, i] {
        values[i] = cache.get(i % 2, [&] {
          ++made;
          std::this_thread::yield();
          return std::make_shared<const std::string>(std::to_string(i % 2));
        });
      });
    for (std::thread& thread : threads)
      thread.join();
    EXPECT_EQ(made, 2);
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_EQ(values[i], values[i % 2]);
  }
}

} // namespace pcl_gpu_icp::test
