// What an iteration asks of OpenCL once buffers and kernels are there: how many launches, waits of the host and
// transfers, which a GPU's driver makes dear. None of them grows with the points.
#include "engine/matcher_internals.h"
#include "faults.h"
#include "kernels/layout.h"
#include "opencl/cl.h"

#include <pcl_gpu_icp/matcher.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace pcl_gpu_icp::test {

namespace {

constexpr unsigned long iterations = 8;

struct Asked {
  unsigned long launches, waits, transfers;
};

std::vector<std::array<float, 3>> hills(int side, float shift)
{
  std::vector<std::array<float, 3>> points;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const float x = 0.25F * static_cast<float>(i) + shift, y = 0.25F * static_cast<float>(j) - shift;
      points.push_back({x, y, 0.4F * std::sin(0.9F * x) * std::cos(1.3F * y) + 0.02F * x * y});
    }
  return points;
}

Points viewOf(const std::vector<std::array<float, 3>>& points)
{
  return {points.data(), points.size(), sizeof(points[0])};
}

/// Of `iterations` of them.
Asked askedBy(Metric metric, const opencl::Traits& traits, int side)
{
  const auto source = hills(side, 0.03F), target = hills(side, 0);
  const std::vector<std::array<float, 3>> normals(target.size(), {0, 0, 1});
  const std::vector<std::array<float, COVARIANCE_ROWS>> covariances(target.size(), {1, 0, 0, 1, 0, 1});
  const Points covariances_view{covariances.data(), covariances.size(), sizeof(covariances[0])};
  Matcher matcher = makeMatcher(Device::select(), traits, Precision::Double);
  matcher.setTarget(matcher.makeTarget(viewOf(target)));
  matcher.setSource(viewOf(source));
  if (metric == Metric::Plane)
    matcher.setTargetNormals(viewOf(normals));
  if (metric == Metric::Generalized) {
    matcher.setTargetCovariances(covariances_view);
    matcher.setSourceCovariances(covariances_view);
  }
  RigidTransform pose;
  const auto iterate = [&] { pose = compose(matcher.match(pose, 1e9F).increment.transform, pose); };
  for (int first = 0; first < 2; ++first)
    iterate();      // buffers are made, and PoCL compiles each kernel for its size
  faults::disarm(); // counts from here
  for (unsigned long i = 0; i < iterations; ++i)
    iterate();
  auto calls = faults::calls();
  const unsigned long transfers =
      calls["clEnqueueMapBuffer"] + calls["clEnqueueReadBuffer"] + calls["clEnqueueWriteBuffer"];
  // Every transfer is one that the host waits for.
  return {calls["clEnqueueNDRangeKernel"], transfers + calls["clFinish"], transfers};
}

} // namespace

/// Memory that the host maps, or that is copied.
class CallsTest : public testing::TestWithParam<bool> {
protected:
  void expectPerIteration(Metric metric, const Asked& each)
  {
    opencl::Traits traits = opencl::Traits::of(Device::select().info());
    traits.mapped_memory = GetParam();
    for (const int side : {20, 150}) {
      SCOPED_TRACE(std::to_string(side * side) + " points");
      const Asked asked = askedBy(metric, traits, side);
      EXPECT_EQ(asked.launches, each.launches * iterations);
      EXPECT_EQ(asked.waits, each.waits * iterations);
      EXPECT_EQ(asked.transfers, each.transfers * iterations);
    }
  }
};

TEST_P(CallsTest, ToPointsTwoLaunchesAndOneWait) { expectPerIteration(Metric::Point, {2, 1, 1}); }

TEST_P(CallsTest, ToPlanesFourLaunchesAndTwoWaits) { expectPerIteration(Metric::Plane, {4, 2, 2}); }

TEST_P(CallsTest, ToCovariancesFourLaunchesAndTwoWaits) { expectPerIteration(Metric::Generalized, {4, 2, 2}); }

INSTANTIATE_TEST_SUITE_P(Memory, CallsTest, testing::Bool(), [](const auto& info) {
  return std::string(info.param ? "Mapped" : "Copied");
});

} // namespace pcl_gpu_icp::test
