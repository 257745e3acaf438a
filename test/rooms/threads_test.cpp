// Several estimators on several threads of one device: the same bits as alone.
#include "engine/estimator_internals.h"
#include "estimator_cases.h"

#include <atomic>
#include <thread>

namespace pcl_gpu_icp::test {

namespace {

constexpr unsigned threads = 4;
constexpr unsigned clouds = 6;

/// Runs `work(thread)` on every thread at once and waits.
template <typename Work>
void onThreads(const Work& work)
{
  std::vector<std::thread> running;
  for (unsigned thread = 0; thread < threads; ++thread)
    running.emplace_back([&work, thread] { work(thread); });
  for (std::thread& thread : running)
    thread.join();
}

} // namespace

class Threads : public WithEstimator {
protected:
  Threads()
  {
    Random random(1);
    for (unsigned i = 0; i < clouds; ++i) {
      const std::size_t n = device().affordable(100 + 1700 * i);
      sources_.push_back(random.cloud(n));
      targets_.push_back(moved(sources_.back(), random.motion(3)));
    }
  }

  Estimate estimateWith(RigidEstimator& estimator, unsigned i)
  {
    return estimator.estimate(viewOf(sources_[i]), viewOf(targets_[i]));
  }

  std::vector<Cloud> sources_, targets_;
};

TEST_P(Threads, GiveTheBitsOfOneThread)
{
  std::vector<Estimate> alone;
  for (unsigned i = 0; i < clouds; ++i)
    alone.push_back(estimateWith(estimator_, i));
  std::atomic<unsigned> different{0};
  onThreads([&](unsigned thread) {
    RigidEstimator mine = GetParam().estimator();
    for (unsigned run = 0; run < 3 * clouds; ++run) {
      const unsigned i = (run + thread) % clouds;
      if (!identical(estimateWith(mine, i), alone[i]))
        ++different;
    }
  });
  EXPECT_EQ(different, 0U);
}

// Kernels that nobody has built yet are built by whichever thread comes first.
TEST_P(Threads, MayBeTheFirstToUseAKernel)
{
  const Estimate expected = estimateWith(estimator_, 1);
  std::atomic<unsigned> failures{0};
  onThreads([&](unsigned) {
    opencl::Traits traits = device().traits;
    traits.work_group_size = 64;
    RigidEstimator mine = makeEstimator(device().device, traits, GetParam().pipeline, device().precision);
    const Estimate result = estimateWith(mine, 1);
    if (rmsDifference(isometryOf(result.transform), isometryOf(expected.transform), sources_[1]) > 1e-5)
      ++failures;
  });
  EXPECT_EQ(failures, 0U);
}

TEST_P(Threads, MayEachSelectADevice)
{
  std::atomic<unsigned> failures{0};
  onThreads([&](unsigned) {
    const DeviceInfo& wanted = device().device.info();
    const Device mine =
        Device::select(std::to_string(wanted.platform_index) + ":" + std::to_string(wanted.device_index));
    RigidEstimator estimator(mine, GetParam().pipeline, device().precision);
    if (estimateWith(estimator, 0).pairs != std::size_t(sources_[0].cols()))
      ++failures;
  });
  EXPECT_EQ(failures, 0U);
}

RUN_EVERY_KERNEL_ESTIMATOR(Threads);

} // namespace pcl_gpu_icp::test
