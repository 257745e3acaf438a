// Pairs on lanes: order, failures, cancelling, several devices. What a pair does is the test's own; the device is real.
#include "device_cases.h"
#include "reference.h"
#include "scoped_environment.h"
#include "watchdog.h"

#include <pcl_gpu_icp/batch_lanes.h>
#include <pcl_gpu_icp/error.h>

#include <atomic>
#include <numeric>
#include <thread>

namespace pcl_gpu_icp::test {

namespace {

BatchResult converged()
{
  BatchResult result;
  result.alignment.converged = true;
  result.alignment.reason = Reason::Transform;
  return result;
}

/// A pair that uses the lane's device, as aligners do.
BatchResult matchOn(DeviceLane& lane, const Cloud& source, const Cloud& target)
{
  lane.matcher = std::make_unique<Matcher>(lane.device, CorrespondenceSearch::DeviceKdTree, Precision::Float);
  lane.matcher->setShare(lane.share);
  lane.matcher->setTarget(lane.matcher->makeTarget(viewOf(target)));
  lane.matcher->setSource(viewOf(source));
  BatchResult result = converged();
  result.transform = lane.matcher->match({}, 1e9F).increment.transform;
  return result;
}

} // namespace

class BatchLanesTest : public testing::Test {
protected:
  std::vector<BatchResult> run(const std::function<void(std::size_t, const BatchResult&)>& finished = {})
  {
    return lanes_.run(devices_, settings_, finished);
  }

  std::vector<Device> devices_{Device::select()};
  BatchSettings settings_;
  BatchLanes lanes_;
  Watchdog watchdog_;
};

TEST_F(BatchLanesTest, ResultsComeInTheOrderAdded)
{
  for (std::size_t i = 0; i < 100; ++i)
    EXPECT_EQ(lanes_.add(100 - i,
                         [i](DeviceLane&) {
                           BatchResult result = converged();
                           result.alignment.iterations = int(i);
                           return result;
                         }),
              i);
  std::vector<std::size_t> finished;
  const auto results = run([&](std::size_t pair, const BatchResult& result) {
    EXPECT_EQ(result.alignment.iterations, int(pair));
    finished.push_back(pair);
  });
  ASSERT_EQ(results.size(), 100U);
  for (std::size_t i = 0; i < 100; ++i)
    EXPECT_EQ(results[i].alignment.iterations, int(i));
  std::sort(finished.begin(), finished.end());
  std::vector<std::size_t> all(100);
  std::iota(all.begin(), all.end(), 0U);
  EXPECT_EQ(finished, all) << "each once";
  EXPECT_EQ(lanes_.add(1, [](DeviceLane&) { return converged(); }), 100U) << "numbers go on";
  EXPECT_EQ(run().size(), 1U);
  EXPECT_TRUE(run().empty());
}

TEST_F(BatchLanesTest, ResultsAreNotKeptOnRequest)
{
  settings_.keep_results = false;
  for (int i = 0; i < 10; ++i)
    lanes_.add(1, [](DeviceLane&) { return converged(); });
  std::size_t told = 0;
  EXPECT_TRUE(run([&](std::size_t, const BatchResult& result) { told += result.alignment.converged ? 1 : 0; }).empty());
  EXPECT_EQ(told, 10U);
}

TEST_F(BatchLanesTest, OneLaneTakesTheSmallestFirstUnlessALargeOneWasOvertakenTooOften)
{
  settings_.lanes = 1;
  std::vector<std::size_t> order;
  lanes_.add(1'000'000, [](DeviceLane&) { return converged(); });
  for (std::size_t i = 1; i < 200; ++i)
    lanes_.add(1000 - i, [](DeviceLane&) { return converged(); });
  run([&](std::size_t pair, const BatchResult&) { order.push_back(pair); });
  const auto large = std::find(order.begin(), order.end(), 0U) - order.begin();
  EXPECT_EQ(large, 64) << "Plan::most_overtaken_by_default";
  EXPECT_EQ(order.front(), 199U);

  order.clear();
  settings_.policy = Policy::FirstComeFirstServed;
  for (const std::size_t points : {5, 1, 3})
    lanes_.add(points, [](DeviceLane&) { return converged(); });
  run([&](std::size_t pair, const BatchResult&) { order.push_back(pair); });
  EXPECT_EQ(order, (std::vector<std::size_t>{200, 201, 202}));
}

TEST_F(BatchLanesTest, NeverMorePointsInFlightThanAllowedButForAPairThatIsLargerAlone)
{
  settings_.lanes = 6;
  settings_.points_in_flight = 100;
  std::atomic<std::size_t> in_flight{0}, pairs{0};
  std::atomic<bool> exceeded{false};
  for (std::size_t i = 0; i < 60; ++i) {
    const std::size_t points = i % 20 == 0 ? 500 : 5 + i;
    lanes_.add(points, [&, points](DeviceLane&) {
      const std::size_t now = in_flight += points;
      ++pairs;
      if (points == 500 ? now != 500 : now > 100)
        exceeded = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      in_flight -= points;
      return converged();
    });
  }
  run();
  EXPECT_EQ(pairs, 60U);
  EXPECT_FALSE(exceeded);
}

TEST_F(BatchLanesTest, AFailureStaysWithItsPair)
{
  Random random(1);
  const Cloud source = random.cloud(300), target = random.cloud(300);
  const auto match = [&](DeviceLane& lane) { return matchOn(lane, source, target); };
  for (std::size_t i = 0; i < 8; ++i)
    lanes_.add(600, match);
  lanes_.add(600, [](DeviceLane&) -> BatchResult { throw std::runtime_error("no such scan"); });
  lanes_.add(600, [](DeviceLane&) -> BatchResult { throw 42; });
  lanes_.add(600, [](DeviceLane&) -> BatchResult { throw DeviceError({-4, "clCreateBuffer", "", ""}, "too large"); });
  lanes_.add(600, [&](DeviceLane& lane) -> BatchResult {
    matchOn(lane, source, target);
    lane.matcher.reset();
    throw std::bad_alloc();
  });
  const auto results = run();
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_TRUE(results[i].alignment.converged) << results[i].alignment.message;
    EXPECT_EQ(results[i].transform.rotation, results[0].transform.rotation);
  }
  for (std::size_t i = 8; i < 12; ++i) {
    EXPECT_EQ(results[i].alignment.reason, Reason::Error);
    EXPECT_FALSE(results[i].alignment.converged);
  }
  EXPECT_EQ(results[8].alignment.message, "no such scan");
  EXPECT_NE(results[10].alignment.message.find("CL_MEM_OBJECT_ALLOCATION_FAILURE"), std::string::npos);
}

TEST_F(BatchLanesTest, CancelledPairsEndAndTheOthersFinish)
{
  settings_.lanes = 2;
  std::atomic<bool> running{false};
  // Uses the device until it is cancelled.
  const auto endless = lanes_.add(1, [&](DeviceLane& lane) -> BatchResult {
    for (running = true;; std::this_thread::yield())
      lane.share->release(lane.share->request("endless", 1));
  });
  const auto waiting = lanes_.add(3, [](DeviceLane&) { return converged(); });
  const auto fine = lanes_.add(2, [](DeviceLane&) { return converged(); });
  lanes_.cancel(waiting);
  std::thread canceller([&] {
    while (!running)
      std::this_thread::yield();
    lanes_.cancel(endless);
  });
  const auto results = run();
  canceller.join();
  EXPECT_EQ(results[endless].alignment.reason, Reason::Cancelled);
  EXPECT_EQ(results[waiting].alignment.reason, Reason::Cancelled);
  EXPECT_EQ(results[fine].alignment.reason, Reason::Transform);
}

TEST_F(BatchLanesTest, AllOfThemCanBeCancelledFromTheCallback)
{
  settings_.lanes = 1;
  for (int i = 0; i < 10; ++i)
    lanes_.add(1, [](DeviceLane&) { return converged(); });
  std::size_t finished = 0;
  const auto results = run([&](std::size_t, const BatchResult&) {
    if (++finished == 3)
      lanes_.cancel();
  });
  EXPECT_EQ(std::count_if(results.begin(), results.end(), [](const BatchResult& r) { return r.alignment.converged; }),
            3);
  EXPECT_EQ(finished, 10U) << "cancelled ones are told of, too";
  EXPECT_EQ(results.back().alignment.reason, Reason::Cancelled);
}

TEST_F(BatchLanesTest, WhatTheCallbackThrowsComesOut)
{
  for (int i = 0; i < 10; ++i)
    lanes_.add(1, [](DeviceLane&) { return converged(); });
  EXPECT_THROW(run([](std::size_t, const BatchResult&) { throw std::domain_error("disk full"); }), std::domain_error);
  lanes_.add(1, [](DeviceLane&) { return converged(); });
  EXPECT_TRUE(run().front().alignment.converged) << "and another run is possible";
}

TEST_F(BatchLanesTest, ALostDeviceEndsTheRemainingPairsWithTheReason)
{
  settings_.lanes = 1;
  std::size_t pairs_run = 0;
  std::unique_ptr<ScopedEnvironment> lost;
  lanes_.add(1, [&](DeviceLane&) -> BatchResult {
    // From now on every buffer is refused.
    lost = std::make_unique<ScopedEnvironment>("PCL_GPU_ICP_MAX_ALLOCATION", "16");
    throw DeviceError({-2, "clFinish", "", ""}, "gone");
  });
  for (int i = 0; i < 20; ++i)
    lanes_.add(2, [&](DeviceLane& lane) -> BatchResult {
      ++pairs_run;
      return matchOn(lane, Cloud::Zero(3, 4), Cloud::Zero(3, 4));
    });
  const auto results = run();
  lost.reset();
  EXPECT_EQ(pairs_run, 0U) << "nobody tries again on what is lost";
  for (std::size_t i = 1; i < results.size(); ++i) {
    EXPECT_EQ(results[i].alignment.reason, Reason::Error);
    EXPECT_NE(results[i].alignment.message.find("the device was lost: "), std::string::npos);
    EXPECT_NE(results[i].alignment.message.find("16"), std::string::npos) << results[i].alignment.message;
  }
}

TEST_F(BatchLanesTest, BadArguments)
{
  EXPECT_THROW(lanes_.add(1, {}), InvalidArgument);
  EXPECT_THROW(lanes_.run({}, settings_, {}), InvalidArgument);
  lanes_.add(1, [&](DeviceLane&) {
    EXPECT_THROW(lanes_.add(1, [](DeviceLane&) { return converged(); }), InvalidArgument);
    EXPECT_THROW(run(), InvalidArgument);
    return converged();
  });
  EXPECT_TRUE(run().front().alignment.converged);
}

TEST_F(BatchLanesTest, PairsGoToWhicheverDeviceIsFree)
{
  std::vector<Device> parts;
  for (const Device& device : Device::list())
    if (device.info().compute_units >= 2 && device.info().platform == "Portable Computing Language")
      parts = device.partition(1);
  ASSERT_GE(parts.size(), 2U) << "PoCL divides its CPU";
  EXPECT_EQ(parts[0].info().compute_units, 1U);
  devices_ = {parts[0], parts[1]};
  settings_.lanes = 1;
  Random random(2);
  const Cloud source = random.cloud(2000), target = random.cloud(2000);
  for (int i = 0; i < 12; ++i)
    lanes_.add(4000, [&](DeviceLane& lane) { return matchOn(lane, source, target); });
  const auto results = run();
  std::size_t on_device[2] = {0, 0};
  for (const BatchResult& result : results) {
    ASSERT_TRUE(result.alignment.converged) << result.alignment.message;
    EXPECT_EQ(result.transform.rotation, results[0].transform.rotation) << "the same bits on both";
    ++on_device[result.device];
  }
  EXPECT_GT(on_device[0], 0U);
  EXPECT_GT(on_device[1], 0U);
  EXPECT_THROW(parts[0].partition(64), DeviceError);
}

} // namespace pcl_gpu_icp::test
