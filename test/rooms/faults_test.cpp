// Every OpenCL call of an alignment made to fail once: the error names it, nothing is left on the device, nobody waits
// for ever, and the next alignment is what it would have been.
#include "faults.h"
#include "opencl/cl.h"
#include "watchdog.h"

#include <pcl_gpu_icp/error.h>
#include <pcl_gpu_icp/matcher.h>
#include <pcl_gpu_icp/normal_estimator.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_gpu_icp::test {

namespace {

struct Aligned {
  CorrespondenceSearch search;
  Metric metric;
};

std::vector<std::array<float, 3>> hills(float shift)
{
  std::vector<std::array<float, 3>> points;
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j) {
      const float x = 0.25F * static_cast<float>(i) + shift, y = 0.25F * static_cast<float>(j) - shift;
      points.push_back({x, y, 0.4F * std::sin(0.9F * x) * std::cos(1.3F * y) + 0.02F * x * y + shift});
    }
  return points;
}

Points viewOf(const std::vector<std::array<float, 3>>& points)
{
  return {points.data(), points.size(), sizeof(points[0])};
}

RigidTransform align(const Device& device, const Aligned& how)
{
  const auto source = hills(0.03F), target = hills(0);
  Matcher matcher(device, how.search, Precision::Double, how.metric);
  if (how.search == CorrespondenceSearch::PclKdTree) {
    const auto index = std::make_shared<search::NearestIndex>();
    index->build(viewOf(target));
    matcher.setTarget(matcher.makeTarget(index));
  }
  else
    matcher.setTarget(matcher.makeTarget(viewOf(target)));
  if (how.metric == Metric::Plane) {
    NormalEstimator estimator(device, Precision::Double);
    const auto normals = estimator.estimate(viewOf(target));
    estimator.takeTimes();
    matcher.setTargetNormals(viewOf(normals));
  }
  matcher.setSource(viewOf(source));
  RigidTransform pose;
  for (int iteration = 0; iteration < 3; ++iteration)
    pose = compose(matcher.match(pose, 1e9F).increment.transform, pose);
  matcher.meanSquaredDistance(pose);
  matcher.correspondences(pose);
  matcher.takeTimes();
  return pose;
}

bool starts(const std::string& text, const char* with) { return text.rfind(with, 0) == 0; }

} // namespace

class FaultsTest : public testing::TestWithParam<Aligned> {
protected:
  Watchdog watchdog_;
};

TEST_P(FaultsTest, EachCallFailsOnce)
{
  const Device device = Device::select();
  align(device, GetParam()); // the context and the programs, which stay
  faults::arm({});
  const RigidTransform expected = align(device, GetParam());
  const auto calls = faults::calls();
  auto live = faults::live();
  ASSERT_GT(calls.at("clEnqueueNDRangeKernel"), 6U);

  for (const auto& [function, count] : calls)
    for (unsigned long call = 1; call <= std::min(count, 100UL); ++call)
      for (const int code : {CL_OUT_OF_RESOURCES, CL_OUT_OF_HOST_MEMORY}) {
        SCOPED_TRACE(function + " " + std::to_string(call) + " of " + std::to_string(count));
        faults::Fault fault;
        fault.function = function;
        fault.call = call;
        fault.code = code;
        faults::arm(fault);
        std::optional<RigidTransform> found;
        try {
          found = align(device, GetParam());
        } catch (const DeviceError& error) {
          EXPECT_EQ(error.code(), code);
          EXPECT_EQ(error.call(), starts(function, "clRetain") ? "clRetain..." : function);
          EXPECT_NE(std::string(error.what()).find(error.codeName()), std::string::npos);
        }
        faults::disarm();
        // What only ends something has no say in the answer: releases, and a queue's last words.
        const bool may_pass =
            starts(function, "clRelease") || function == "clFinish" || function == "clEnqueueUnmapMemObject";
        if (found) {
          EXPECT_TRUE(may_pass);
          EXPECT_EQ(found->rotation, expected.rotation);
          EXPECT_EQ(found->translation, expected.translation);
        }
        auto left = faults::live();
        for (const char* kind : {"buffer", "queue", "kernel", "event"})
          EXPECT_TRUE(left[kind] == live[kind] || starts(function, "clRelease")) << left[kind] << ' ' << kind;
        live = left; // what was not released stays
        const RigidTransform again = align(device, GetParam());
        EXPECT_EQ(again.rotation, expected.rotation);
        EXPECT_EQ(again.translation, expected.translation);
      }
}

INSTANTIATE_TEST_SUITE_P(Alignments,
                         FaultsTest,
                         testing::Values(Aligned{CorrespondenceSearch::PclKdTree, Metric::Point},
                                         Aligned{CorrespondenceSearch::DeviceKdTree, Metric::Point},
                                         Aligned{CorrespondenceSearch::PclKdTree, Metric::Plane},
                                         Aligned{CorrespondenceSearch::DeviceKdTree, Metric::Plane}),
                         [](const auto& info) {
                           return std::string(info.param.search == CorrespondenceSearch::PclKdTree ? "Host"
                                                                                                   : "Device") +
                                  (info.param.metric == Metric::Point ? "Points" : "Planes");
                         });

} // namespace pcl_gpu_icp::test
