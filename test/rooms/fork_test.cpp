// fork(): OpenCL does not survive it, so a child gets an error instead of a hang, and the parent keeps working.
#include "device_cases.h"
#include "opencl/queue.h"

#include <pcl_gpu_icp/error.h>

#include <functional>
#include <sys/wait.h>
#include <unistd.h>

namespace pcl_gpu_icp::test {

using opencl::Buffer;
using opencl::Queue;

namespace {

enum Verdict { refused = 10, not_refused = 11, unclear = 12 };

/// What `action` meets in a child process. A hang ends by SIGALRM and is -1.
int inChild(const std::function<void()>& action)
{
  const pid_t child = fork();
  if (child == 0) {
    alarm(20);
    int verdict = not_refused;
    try {
      action();
    } catch (const DeviceError& error) {
      verdict = std::string(error.what()).find("fork()") != std::string::npos ? refused : unclear;
    } catch (...) {
      verdict = unclear;
    }
    _exit(verdict);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

} // namespace

class Fork : public OnDevice {
protected:
  Queue queue_{GetParam().device, GetParam().traits, "-cl-std=CL1.2"};
  Buffer buffer_{"bytes"};
  static void fill(void* memory) { *static_cast<char*>(memory) = 42; }
};

TEST_P(Fork, TheChildIsRefusedADevice)
{
  EXPECT_EQ(inChild([] { Device::list(); }), refused);
  EXPECT_EQ(inChild([] { Device::select(); }), refused);
}

TEST_P(Fork, TheChildIsRefusedAQueue)
{
  EXPECT_EQ(inChild([] { Queue(GetParam().device, GetParam().traits, ""); }), refused);
}

TEST_P(Fork, TheChildIsRefusedTheParentsQueue)
{
  queue_.upload(buffer_, 1, fill);
  EXPECT_EQ(inChild([&] { queue_.upload(buffer_, 1, fill); }), refused);
  EXPECT_EQ(inChild([&] { queue_.download(buffer_, 1, [](const void*) {}); }), refused);
  EXPECT_EQ(inChild([&] { queue_.takeProfile(); }), refused);
}

TEST_P(Fork, TheChildCanDestroyWhatItInherited)
{
  auto queue = std::make_unique<Queue>(GetParam().device, GetParam().traits, "-cl-std=CL1.2");
  auto buffer = std::make_unique<Buffer>("bytes");
  queue->upload(*buffer, 1, fill);
  EXPECT_EQ(inChild([&] {
              buffer.reset();
              queue.reset();
            }),
            not_refused);
}

TEST_P(Fork, TheParentKeepsWorking)
{
  EXPECT_EQ(inChild([] { Device::list(); }), refused);
  queue_.upload(buffer_, 1, fill);
  char byte = 0;
  queue_.download(buffer_, 1, [&](const void* memory) { byte = *static_cast<const char*>(memory); });
  EXPECT_EQ(byte, 42);
}

RUN_WITH_EVERY_MEMORY(Fork);

} // namespace pcl_gpu_icp::test
