// Queue: data to the device and back, launches, limits, times.
#include "device_cases.h"
#include "generous_share.h"
#include "opencl/queue.h"
#include "scoped_directory.h"
#include "scoped_environment.h"

#include <pcl_gpu_icp/error.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <thread>
#include <vector>

namespace pcl_gpu_icp::test {

using opencl::Buffer;
using opencl::Queue;
using opencl::Traits;

class QueueOf : public OnDevice {
protected:
  QueueOf()
  : kernels_("PCL_GPU_ICP_KERNEL_DIR", directory_.path())
  {
    directory_.write("double.cl",
                     "kernel void twice(global int* values, int n)\n"
                     "{\n"
                     "  const int i = get_global_id(0);\n"
                     "  if (i < n)\n"
                     "    values[i] *= 2;\n"
                     "}\n");
  }

  Queue& queue() { return queue_; }

  void upload(Buffer& buffer, const std::vector<int>& values)
  {
    const std::size_t bytes = values.size() * sizeof(int);
    queue_.upload(buffer, bytes, [&](void* memory) { std::memcpy(memory, values.data(), bytes); });
  }

  std::vector<int> download(const Buffer& buffer, std::size_t n)
  {
    std::vector<int> values(n);
    const auto copy = [&](const void* memory) { std::memcpy(values.data(), memory, n * sizeof(int)); };
    queue_.download(buffer, n * sizeof(int), copy);
    return values;
  }

  void twice(Buffer& buffer, std::size_t n)
  {
    queue_.launch("twice", {"double.cl", "twice"}, {cl::NDRange(n), cl::NDRange(1)}, buffer, cl_int(n));
  }

private:
  ScopedDirectory directory_;
  ScopedEnvironment kernels_;
  Queue queue_{GetParam().device, GetParam().traits, "-cl-std=CL1.2"};
};

TEST_P(QueueOf, RunsAKernelOnWhatWasUploaded)
{
  Buffer buffer("integers");
  std::vector<int> values(1000);
  std::iota(values.begin(), values.end(), 0);
  upload(buffer, values);
  twice(buffer, values.size());
  const auto doubled = download(buffer, values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    ASSERT_EQ(doubled[i], 2 * values[i]);
}

TEST_P(QueueOf, BuffersGrowAndKeepTheirRoom)
{
  Buffer buffer("integers");
  upload(buffer, {1, 2, 3});
  const std::size_t small = buffer.capacity();
  EXPECT_GE(small, 3 * sizeof(int));
  const std::vector<int> many(small / sizeof(int) + 5000, 7);
  upload(buffer, many);
  const std::size_t large = buffer.capacity();
  EXPECT_GE(large, many.size() * sizeof(int));
  EXPECT_EQ(download(buffer, many.size()), many);
  upload(buffer, {4, 5});
  EXPECT_EQ(buffer.capacity(), large);
  EXPECT_EQ(download(buffer, 2), (std::vector<int>{4, 5}));
}

TEST_P(QueueOf, NothingIsUploadedAsNothing)
{
  Buffer buffer("integers");
  EXPECT_NO_THROW(upload(buffer, {}));
  EXPECT_TRUE(download(buffer, 0).empty());
}

TEST_P(QueueOf, CountsCommandsByStageAndTransfer)
{
  Buffer buffer("integers");
  upload(buffer, {1, 2, 3});
  twice(buffer, 3);
  twice(buffer, 3);
  download(buffer, 3);
  const auto entries = queue().takeProfile().entries;
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_EQ(entries.at("upload").count, 1U);
  EXPECT_EQ(entries.at("twice").count, 2U);
  EXPECT_EQ(entries.at("download").count, 1U);
  for (const auto& [what, entry] : entries)
    EXPECT_GE(entry.milliseconds, 0) << what;
  EXPECT_TRUE(queue().takeProfile().entries.empty());
}

TEST_P(QueueOf, LosesNoCommandOfManyFromItsProfile)
{
  Buffer buffer("integers");
  upload(buffer, {1});
  for (int i = 0; i < 700; ++i) {
    twice(buffer, 1);
    download(buffer, 1);
  }
  const auto entries = queue().takeProfile().entries;
  EXPECT_EQ(entries.at("twice").count, 700U);
  EXPECT_EQ(entries.at("download").count, 700U);
}

TEST_P(QueueOf, AnExceptionWhileFillingLeavesTheQueueUsable)
{
  Buffer buffer("integers");
  const auto fail = [](void*) { throw std::runtime_error("cannot fill"); };
  EXPECT_THROW(queue().upload(buffer, 64, fail), std::runtime_error);
  upload(buffer, {1, 2, 3});
  twice(buffer, 3);
  EXPECT_EQ(download(buffer, 3), (std::vector<int>{2, 4, 6}));
}

TEST_P(QueueOf, AnExceptionWhileReadingLeavesTheQueueUsable)
{
  Buffer buffer("integers");
  upload(buffer, {1, 2, 3});
  const auto fail = [](const void*) { throw std::runtime_error("cannot read"); };
  EXPECT_THROW(queue().download(buffer, 4, fail), std::runtime_error);
  twice(buffer, 3);
  EXPECT_EQ(download(buffer, 3), (std::vector<int>{2, 4, 6}));
}

TEST_P(QueueOf, AKernelThatIsNotThereIsNamed)
{
  Buffer buffer("integers");
  upload(buffer, {1});
  try {
    queue().launch("stage", {"double.cl", "thrice"}, {cl::NDRange(1), cl::NDRange(1)}, buffer);
    FAIL() << "nothing was thrown";
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.code(), CL_INVALID_KERNEL_NAME);
    EXPECT_EQ(error.kernel(), "thrice");
    EXPECT_EQ(error.device(), GetParam().device.info().name);
  }
}

TEST_P(QueueOf, ALaunchTheDeviceRefusesIsNamed)
{
  Buffer buffer("integers");
  upload(buffer, {1});
  const std::size_t group = 2 * GetParam().device.info().max_work_group_size;
  try {
    queue().launch("stage", {"double.cl", "twice"}, {cl::NDRange(group), cl::NDRange(group)}, buffer, cl_int(1));
    FAIL() << "nothing was thrown";
  } catch (const DeviceError& error) {
    EXPECT_STRNE(error.codeName(), "unknown OpenCL error");
    EXPECT_EQ(error.kernel(), "twice");
  }
  EXPECT_EQ(download(buffer, 1), std::vector<int>{1});
}

TEST_P(QueueOf, RefusesABufferOverTheLimitWithBothNumbers)
{
  Traits traits = GetParam().traits;
  traits.max_allocation = 4096;
  Queue limited(GetParam().device, traits, "-cl-std=CL1.2");
  Buffer buffer("point pairs");
  EXPECT_NO_THROW(limited.reserve(buffer, 4096));
  EXPECT_EQ(buffer.capacity(), 4096U);
  try {
    limited.reserve(buffer, 4097);
    FAIL() << "nothing was thrown";
  } catch (const DeviceError& error) {
    const std::string what = error.what();
    for (const char* part : {"point pairs", "4097", "4096", "CL_MEM_OBJECT_ALLOCATION_FAILURE"})
      EXPECT_NE(what.find(part), std::string::npos) << what;
  }
  EXPECT_EQ(buffer.capacity(), 4096U) << "what was there is kept";
}

using Log = std::vector<std::string>;

TEST_P(QueueOf, AsksForTheWorkItemsOfEachLaunch)
{
  const auto share = std::make_shared<GenerousShare>(100);
  queue().setShare(share);
  Buffer buffer("numbers");
  upload(buffer, std::vector<int>(64, 1));
  EXPECT_EQ(share->log, Log{}) << "copying is no operation";
  twice(buffer, 64);
  twice(buffer, 64);
  twice(buffer, 32);
  twice(buffer, 16);
  twice(buffer, 48);
  EXPECT_EQ(share->log, (Log{"request 64", "narrow 64", "narrow 32", "narrow 16", "release", "request 48"}));
  share->log.clear();
  const auto values = download(buffer, 64);
  EXPECT_EQ(share->log, Log{"release"}) << "before the host looks at them";
  EXPECT_EQ(values[0], 32);
  EXPECT_EQ(values[20], 16);
  EXPECT_EQ(values[63], 4);
  queue().finish();
  EXPECT_EQ(share->log, Log{"release"}) << "once";
}

TEST_P(QueueOf, RunsALaunchForMoreThanTheDeviceHasInPasses)
{
  const auto share = std::make_shared<GenerousShare>(10);
  queue().setShare(share);
  Buffer buffer("numbers");
  std::vector<int> expected(24);
  std::iota(expected.begin(), expected.end(), 1);
  upload(buffer, expected);
  twice(buffer, expected.size());
  for (int& value : expected)
    value *= 2;
  EXPECT_EQ(download(buffer, expected.size()), expected);
  EXPECT_EQ(share->log, (Log{"request 10", "release", "request 10", "release", "request 4", "release"}));
}

TEST_P(QueueOf, GivesBackWhatItHoldsInTheEnd)
{
  const auto share = std::make_shared<GenerousShare>(100);
  {
    Queue queue(GetParam().device, GetParam().traits, "-cl-std=CL1.2");
    queue.setShare(share);
    Buffer buffer("numbers");
    queue.upload(buffer, 4, [](void* memory) { *static_cast<int*>(memory) = 1; });
    queue.launch("twice", {"double.cl", "twice"}, {cl::NDRange(1), cl::NDRange(1)}, buffer, cl_int(1));
  }
  EXPECT_EQ(share->log, (Log{"request 1", "release"}));
}

TEST_P(QueueOf, QueuesOfSeveralThreadsLaunchAKernelOverEverMoreWorkItems)
{
  // PoCL counts the uses of a kernel's variants, one for each width that is more than any before, and mixes them up.
  const auto work = [](unsigned thread) {
    Queue own(GetParam().device, GetParam().traits, "-cl-std=CL1.2");
    const auto share = std::make_shared<GenerousShare>(500);
    Buffer buffer("numbers");
    for (std::size_t n = 1 + thread; n < 2000; n += 7) {
      own.setShare(thread % 2 == 0 ? nullptr : share); // with one, in passes
      std::vector<int> values(n, 1);
      own.upload(buffer, n * sizeof(int), [&](void* memory) { std::memcpy(memory, values.data(), n * sizeof(int)); });
      for (int i = 0; i < 3; ++i)
        own.launch("twice", {"double.cl", "twice"}, {cl::NDRange(n), cl::NDRange(1)}, buffer, cl_int(n));
      own.download(buffer, n * sizeof(int), [&](const void* memory) {
        EXPECT_EQ(*std::max_element(static_cast<const int*>(memory), static_cast<const int*>(memory) + n), 8);
        EXPECT_EQ(*std::min_element(static_cast<const int*>(memory), static_cast<const int*>(memory) + n), 8);
      });
    }
  };
  std::vector<std::thread> threads;
  for (unsigned thread = 0; thread < 6; ++thread)
    threads.emplace_back(work, thread);
  for (std::thread& thread : threads)
    thread.join();
}

RUN_WITH_EVERY_MEMORY(QueueOf);

TEST(TraitsOf, ReadTheAllocationLimitFromTheEnvironment)
{
  const ScopedEnvironment environment("PCL_GPU_ICP_MAX_ALLOCATION", "12345");
  for (const Device& device : Device::list())
    EXPECT_EQ(Traits::of(device.info()).max_allocation, 12345U);
}

TEST(TraitsOf, FollowTheDevice)
{
  DeviceInfo info;
  info.type = DeviceInfo::Type::Cpu;
  info.max_work_group_size = 4096;
  info.unified_memory = info.fp64 = true;
  info.max_allocation = 1000;
  const Traits cpu = Traits::of(info);
  EXPECT_EQ(cpu.shape, opencl::Shape::Chunked);
  EXPECT_TRUE(cpu.mapped_memory);
  EXPECT_TRUE(cpu.fp64);
  EXPECT_EQ(cpu.work_group_size, 128U);
  EXPECT_EQ(cpu.max_allocation, 1000U);

  info.type = DeviceInfo::Type::Gpu;
  info.max_work_group_size = 64;
  info.unified_memory = info.fp64 = false;
  const Traits gpu = Traits::of(info);
  EXPECT_EQ(gpu.shape, opencl::Shape::Grouped);
  EXPECT_FALSE(gpu.mapped_memory);
  EXPECT_FALSE(gpu.fp64);
  EXPECT_EQ(gpu.work_group_size, 64U);
}

} // namespace pcl_gpu_icp::test
