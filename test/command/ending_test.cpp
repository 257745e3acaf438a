// What an alignment came to, where what is said of its pose and of its distances differ.
#include "report/ending.h"

#include <gtest/gtest.h>

namespace pcl_gpu_icp::report {
namespace {

/// Stopped at the limit, where the points are farther from the target than at the guess.
AlignmentReport fartherAtTheLimit()
{
  AlignmentReport report;
  AlignmentResult& result = report.result;
  result.converged = true;
  result.reason = Reason::Iterations;
  result.iterations = report.iteration_limit = 100;
  result.inliers = result.source_points = 1000;
  result.truncated_rmse_before = 1;
  result.truncated_rmse = 1.1;
  return report;
}

/// Of surfaces that lie on each other as a whole.
Quality goodQuality()
{
  Quality quality;
  quality.spacing = 1;
  quality.after = {0.98, 0.98};
  quality.median_distance = 0.3;
  quality.concentration = 0.95;
  quality.surfaces = SurfaceFit{0.9, 0.97, 0.05, 0.1, 0.05};
  return quality;
}

TEST(Ending, OfAGoodPoseIsNotWorseForItsDistances)
{
  AlignmentReport report = fartherAtTheLimit();
  EXPECT_EQ(endingOf(report), Ending::GotWorse);
  report.result.quality = goodQuality();
  EXPECT_EQ(endingOf(report), Ending::AtLimit);
  report.searched_guess.emplace().rival.emplace(); // which makes it doubtful, not worse
  EXPECT_EQ(endingOf(report), Ending::AtLimit);
  report.searched_guess.reset();
  report.result.quality->surfaces->pull = 2; // doubtful
  EXPECT_EQ(endingOf(report), Ending::GotWorse);
  report.result.quality = goodQuality();
  report.result.quality->surfaces.reset(); // scattered points, very close
  report.result.quality->median_distance = 0.05;
  EXPECT_EQ(endingOf(report), Ending::GotWorse);
}

} // namespace
} // namespace pcl_gpu_icp::report
