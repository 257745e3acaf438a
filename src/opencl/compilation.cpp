#include "compilation.h"

#include <pcl_gpu_icp/device.h>

#include <algorithm>
#include <mutex>
#include <vector>

namespace pcl_gpu_icp {
namespace opencl {
namespace {

struct Compilations {
  std::mutex mutex;
  std::vector<const Compilation*> all;
};

Compilations& compilations()
{
  static auto& only = *new Compilations; // outlives all queues
  return only;
}

} // namespace

Compilation::Compilation()
{
  const std::lock_guard<std::mutex> lock(compilations().mutex);
  compilations().all.push_back(this);
}

Compilation::Compilation(const cl::Event& launch)
: launch_(&launch)
{
  const std::lock_guard<std::mutex> lock(compilations().mutex);
  compilations().all.push_back(this);
}

Compilation::~Compilation()
{
  const std::lock_guard<std::mutex> lock(compilations().mutex);
  auto& all = compilations().all;
  all.erase(std::find(all.begin(), all.end(), this));
}

bool Compilation::isRunning() const
{
  if (!launch_)
    return true;
  cl_int status = CL_COMPLETE;
  clGetEventInfo((*launch_)(), CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, nullptr);
  return status == CL_QUEUED || status == CL_SUBMITTED;
}

} // namespace opencl

bool isCompilingKernels()
{
  const std::lock_guard<std::mutex> lock(opencl::compilations().mutex);
  const auto& all = opencl::compilations().all;
  return std::any_of(all.begin(), all.end(), [](const opencl::Compilation* one) { return one->isRunning(); });
}

} // namespace pcl_gpu_icp
