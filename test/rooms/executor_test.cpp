// The plan run by threads, still without a device.
#include "scheduler/executor.h"
#include "watchdog.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <random>
#include <thread>
#include <vector>

namespace pcl_gpu_icp::scheduler {

using test::Watchdog;

TEST(Executor, ManyThreadsNeverHoldMoreThanThereIs)
{
  const Watchdog watchdog;
  constexpr std::size_t capacity = 100;
  const auto schedule = std::make_shared<Schedule>();
  Executor executor(Plan(capacity), 0, schedule, Executor::Clock::now());
  std::atomic<std::size_t> in_flight{0}, most{0}, operations{0};
  std::vector<std::thread> threads;
  for (std::size_t lane = 0; lane < 8; ++lane)
    threads.emplace_back([&, lane] {
      std::mt19937 random(static_cast<unsigned>(lane));
      LaneShare share(executor, lane);
      for (std::size_t pair = 0; pair < 20; ++pair) {
        share.begin(pair);
        for (int operation = 0; operation < 20; ++operation) {
          std::size_t held = std::uniform_int_distribution<std::size_t>(1, 150)(random);
          const auto grant = share.request("operation", held);
          held = std::min(held, capacity);
          const std::size_t now = in_flight += held;
          std::size_t before = most;
          while (before < now && !most.compare_exchange_weak(before, now)) {
          }
          for (; held > 1; held = (held + 1) / 2) {
            in_flight -= held - (held + 1) / 2;
            share.narrow(grant, "operation", (held + 1) / 2);
          }
          in_flight -= held;
          share.release(grant);
          ++operations;
        }
        share.end();
      }
    });
  for (std::thread& thread : threads)
    thread.join();
  EXPECT_EQ(operations, 8U * 20 * 20);
  EXPECT_EQ(in_flight, 0U);
  EXPECT_LE(most, capacity);
  EXPECT_GT(most, 0U);
  for (const Schedule::Level& level : schedule->levels())
    ASSERT_LE(level.idle, capacity);
  EXPECT_EQ(schedule->levels().back().idle, capacity);
}

TEST(Executor, WhoWaitsIsCancelledAndTheOthersGoOn)
{
  const Watchdog watchdog;
  Executor executor(Plan(10), 0, nullptr, Executor::Clock::now());
  LaneShare holder(executor, 0), waits(executor, 1), next(executor, 2);
  for (LaneShare* share : {&holder, &waits, &next})
    share->begin(0);
  const auto grant = holder.request("all", 10);
  auto cancelled = std::async(std::launch::async, [&] { EXPECT_THROW(waits.request("five", 5), Cancelled); });
  auto goes_on = std::async(std::launch::async, [&] { next.release(next.request("ten", 10)); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  waits.cancel();
  cancelled.get();
  EXPECT_THROW(waits.request("again", 1), Cancelled);
  holder.release(grant);
  goes_on.get();
  waits.begin(1);
  EXPECT_NO_THROW(waits.release(waits.request("another pair", 10))) << "the lane is free for the next pair";
}

TEST(Executor, RecordsWhatRan)
{
  const auto schedule = std::make_shared<Schedule>();
  Executor executor(Plan(10), 3, schedule, Executor::Clock::now());
  LaneShare share(executor, 2);
  share.begin(7);
  const auto grant = share.request("first", 8);
  share.narrow(grant, "second", 4);
  share.release(grant);
  share.end();
  const auto spans = schedule->spans();
  ASSERT_EQ(spans.size(), 3U);
  const char* whats[] = {"first", "second", "pair"};
  const std::size_t items[] = {8, 4, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(spans[i].what, whats[i]);
    EXPECT_EQ(spans[i].work_items, items[i]);
    EXPECT_EQ(spans[i].device, 3U);
    EXPECT_EQ(spans[i].lane, 2U);
    EXPECT_EQ(spans[i].pair, 7U);
    EXPECT_LE(spans[i].begin_ms, spans[i].end_ms);
  }
  EXPECT_LE(spans[0].end_ms, spans[1].begin_ms);
  EXPECT_LE(spans[2].begin_ms, spans[0].begin_ms);
}

} // namespace pcl_gpu_icp::scheduler
