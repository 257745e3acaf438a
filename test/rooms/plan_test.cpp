// The plan of a device that many share: pure arithmetic, no device.
#include "scheduler/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <vector>

namespace pcl_gpu_icp::scheduler {

namespace {

std::vector<Plan::Ticket> startAll(Plan& plan)
{
  std::vector<Plan::Ticket> started;
  while (const auto ticket = plan.startNext())
    started.push_back(*ticket);
  return started;
}

using Tickets = std::vector<Plan::Ticket>;

} // namespace

TEST(Plan, TheSourceDocumentsExample)
{
  // Device x; P's centroid needs y, Q/W's cross-covariance z, with x > y, x > z and x - y < z.
  const std::size_t x = 1000, y = 700, z = 600;
  Plan plan(x);
  const Plan::Ticket centroid = plan.submit(y);
  EXPECT_EQ(startAll(plan), Tickets{centroid});
  const Plan::Ticket covariance = plan.submit(z);
  EXPECT_EQ(startAll(plan), Tickets{}) << "x - y < z: it waits";
  EXPECT_EQ(plan.idle(), x - y);
  plan.narrow(centroid, y / 2);
  EXPECT_GE(plan.idle(), z) << "x - y/2 >= z";
  EXPECT_EQ(startAll(plan), Tickets{covariance});
  EXPECT_EQ(plan.idle(), x - y / 2 - z);
  plan.narrow(centroid, y / 4);
  plan.end(centroid);
  plan.end(covariance);
  EXPECT_EQ(plan.idle(), x);
}

TEST(Plan, TheSmallestRequestIsFirstAndOfEqualOnesTheOldest)
{
  Plan plan(10);
  const auto all = plan.submit(10);
  EXPECT_EQ(startAll(plan), Tickets{all});
  const auto five = plan.submit(5), two = plan.submit(2), two_more = plan.submit(2), nine = plan.submit(9);
  plan.end(all);
  EXPECT_EQ(startAll(plan), (Tickets{two, two_more, five}));
  plan.end(five);
  EXPECT_EQ(startAll(plan), Tickets{}) << "nine do not fit beside four";
  plan.end(two);
  plan.end(two_more);
  EXPECT_EQ(startAll(plan), Tickets{nine});
}

TEST(Plan, OtherPoliciesForComparison)
{
  for (const Policy policy : {Policy::FirstComeFirstServed, Policy::LargestFirst}) {
    Plan plan(10, policy);
    const auto all = plan.submit(10);
    startAll(plan);
    const auto three = plan.submit(3), eight = plan.submit(8), one = plan.submit(1);
    plan.end(all);
    const bool largest = policy == Policy::LargestFirst;
    EXPECT_EQ(startAll(plan), Tickets{largest ? eight : three}) << toString(policy);
    plan.end(largest ? eight : three);
    EXPECT_EQ(startAll(plan), (largest ? Tickets{three, one} : Tickets{eight, one})) << toString(policy);
  }
}

TEST(Plan, ARequestForMoreThanThereIsIsOneForAllOfIt)
{
  Plan plan(8);
  const auto small = plan.submit(1);
  const auto huge = plan.submit(1'000'000);
  EXPECT_EQ(startAll(plan), Tickets{small});
  plan.end(small);
  EXPECT_EQ(startAll(plan), Tickets{huge});
  EXPECT_EQ(plan.held(huge), 8U);
}

TEST(Plan, RequestsOfNothingTakeTheirTurnToo)
{
  Plan plan(0);
  EXPECT_EQ(plan.capacity(), 1U);
  const auto first = plan.submit(0), second = plan.submit(0);
  EXPECT_EQ(startAll(plan), Tickets{first});
  plan.end(first);
  EXPECT_EQ(startAll(plan), Tickets{second});
}

TEST(Plan, WordOfWhatHasEndedChangesNothing)
{
  Plan plan(8);
  const auto ticket = plan.submit(4);
  startAll(plan);
  plan.narrow(ticket, 6);
  EXPECT_EQ(plan.held(ticket), 4U) << "nobody grows";
  plan.end(ticket);
  plan.end(ticket);
  plan.narrow(ticket, 1);
  plan.end(12345);
  EXPECT_EQ(plan.idle(), 8U);
  EXPECT_EQ(plan.held(ticket), 0U);
}

TEST(Plan, OneThatNoLongerWaitsIsNotStarted)
{
  Plan plan(8);
  const auto all = plan.submit(8);
  startAll(plan);
  const auto gone = plan.submit(1), stays = plan.submit(2);
  plan.end(gone);
  plan.end(all);
  EXPECT_EQ(startAll(plan), Tickets{stays});
}

TEST(Plan, AStreamOfSmallRequestsDoesNotStarveALargeOne)
{
  constexpr std::size_t most = 5;
  Plan plan(10, Policy::SmallestFirst, most);
  auto running = plan.submit(1);
  startAll(plan);
  const auto large = plan.submit(10);
  std::size_t overtook = 0;
  for (;; ++overtook) {
    ASSERT_LE(overtook, most);
    const auto next = plan.submit(1);
    const Tickets started = startAll(plan);
    if (started.empty())
      break;
    EXPECT_EQ(started, Tickets{next});
    plan.end(std::exchange(running, next));
  }
  EXPECT_EQ(overtook, most);
  plan.end(running);
  EXPECT_EQ(startAll(plan), Tickets{large});
}

// A number of pairs, each of which goes through its stages in order; every stage shrinks and ends at random.
TEST(Plan, InvariantsOfRandomWorkloads)
{
  for (unsigned seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const auto any = [&](std::size_t low, std::size_t high) {
      return std::uniform_int_distribution<std::size_t>(low, high)(random);
    };
    const std::size_t capacity = any(1, 200), most = any(0, 12);
    const Policy policy = static_cast<Policy>(any(0, 2));
    Plan plan(capacity, policy, most);

    struct Stage {
      std::size_t pair, request, held = 0;
    };
    std::map<Plan::Ticket, Stage> waiting, running;
    std::map<Plan::Ticket, std::size_t> overtaken;
    std::vector<std::size_t> stages_left(any(1, 12));
    for (std::size_t& stages : stages_left)
      stages = any(1, 12);
    const auto submit = [&](std::size_t pair) {
      const std::size_t request = any(1, any(1, 2) == 1 ? 8 : 2 * capacity);
      const auto ticket = plan.submit(request);
      waiting[ticket] = {pair, std::min(request, capacity)};
      overtaken[ticket] = 0;
    };
    const auto start = [&] {
      while (const auto ticket = plan.startNext()) {
        const auto found = waiting.find(*ticket);
        ASSERT_NE(found, waiting.end()) << "started once, and only what waits";
        for (auto older = overtaken.begin(); older->first < *ticket; ++older)
          ASSERT_LE(++older->second, most) << "waiting is bounded";
        overtaken.erase(*ticket);
        Stage stage = found->second;
        stage.held = stage.request;
        waiting.erase(found);
        running[*ticket] = stage;
      }
      std::size_t in_flight = 0;
      for (const auto& [ticket, stage] : running) {
        ASSERT_EQ(plan.held(ticket), stage.held);
        in_flight += stage.held;
      }
      ASSERT_LE(in_flight, capacity) << "never more in flight than there is";
      ASSERT_EQ(plan.idle(), capacity - in_flight);
      ASSERT_EQ(plan.waiting(), waiting.size());
      // No idle device while something fits, but for one that has been overtaken as often as may be.
      if (policy == Policy::SmallestFirst && !waiting.empty() && overtaken.begin()->second < most) {
        for (const auto& [ticket, stage] : waiting)
          ASSERT_GT(stage.request, plan.idle());
      }
      ASSERT_FALSE(running.empty() && !waiting.empty()) << "an idle device takes anything";
    };

    for (std::size_t pair = 0; pair < stages_left.size(); ++pair)
      submit(pair);
    start();
    std::size_t steps = 0;
    while (!running.empty() && !HasFatalFailure()) {
      ASSERT_LT(++steps, 10'000U);
      const auto chosen = std::next(running.begin(), std::ptrdiff_t(any(0, running.size() - 1)));
      if (chosen->second.held > 1 && any(0, 1) == 1) {
        chosen->second.held /= 2;
        plan.narrow(chosen->first, chosen->second.held);
      }
      else {
        const std::size_t pair = chosen->second.pair;
        plan.end(chosen->first);
        running.erase(chosen);
        if (--stages_left[pair] > 0)
          submit(pair); // only now: a pair's stages run in order
      }
      start();
    }
    if (HasFatalFailure())
      return;
    EXPECT_EQ(std::count(stages_left.begin(), stages_left.end(), 0U), std::ptrdiff_t(stages_left.size()))
        << "all finish";
  }
}

} // namespace pcl_gpu_icp::scheduler
