// Aligning where floating-point exceptions trap, and on threads with small stacks.
#include "clouds.h"

#include <pcl_gpu_icp/icp.h>

#include <cfenv>
#include <iostream>
#include <limits>
#include <pthread.h>

using Icp = pcl_gpu_icp::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ>;
using pcl_gpu_icp::CorrespondenceSearch;

namespace {

bool aligns()
{
  for (const auto search : {CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree})
    for (const bool not_finite : {false, true}) {
      Icp icp;
      icp.setCorrespondenceSearch(search);
      const Cloud::Ptr source = hills(shift), target = hills();
      if (not_finite) {
        (*source)[3].x = std::numeric_limits<float>::quiet_NaN();
        (*target)[5].y = std::numeric_limits<float>::infinity();
      }
      icp.setInputSource(source);
      icp.setInputTarget(target);
      if (!findsTheShift(icp)) {
        std::cerr << toString(search) << ": " << icp.getResult().message << '\n';
        return false;
      }
      icp.getFitnessScore();
    }
  return true;
}

/// Runs aligns() on a thread with so many bytes of stack.
bool alignsOn(std::size_t stack)
{
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, stack);
  bool succeeds = false;
  const auto run = [](void* result) -> void* {
    *static_cast<bool*>(result) = aligns();
    return nullptr;
  };
  pthread_t thread;
  if (pthread_create(&thread, &attributes, run, &succeeds) == 0)
    pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
  return succeeds;
}

} // namespace

int main()
{
  int failures = 0;
  const auto expect = [&](bool condition, const char* what) {
    if (condition)
      return;
    std::cerr << what << '\n';
    ++failures;
  };
  // First of all, so that OpenCL starts with the traps.
  feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
  expect(aligns(), "with traps");
  expect(fegetexcept() == (FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW), "the traps are still there");
  fedisableexcept(FE_ALL_EXCEPT);
  expect(alignsOn(256 << 10), "on 256 KiB of stack");
  return failures > 0 ? 1 : 0;
}
