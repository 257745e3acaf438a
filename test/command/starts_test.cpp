// Alignments as the command does them without options, on pairs that have half or more of their points in common.
#include "started_pair.h"

#include "scans.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace pcl_gpu_icp::cli {
namespace {

TEST(Starts, FromNearbyLeadToTheRightPose)
{
  if (!scans::areThere())
    GTEST_SKIP() << "no scans at " << scans::folder << " (CMake variable PCL_GPU_ICP_SHARED_DATA)";
  int pairs = 0, right_at_once = 0, right = 0, good_and_off = 0;
  AlignmentOptions by_default, once;
  once.once = true;
  for (const made_pairs::Pair& pair : made_pairs::makeNearbyPairs(scans::folder, 1, 9)) {
    SCOPED_TRACE(pair.kind + " " + pair.clouds);
    const made_pairs::StartedPair found = made_pairs::started(pair, by_default);
    if (pair.kind == "shared") {
      EXPECT_TRUE(found.isRight());
    }
    ++pairs;
    right_at_once += made_pairs::started(pair, once).isRight() ? 1 : 0;
    right += found.isRight() ? 1 : 0;
    good_and_off += !found.isRight() && found.verdict() == Verdict::Good ? 1 : 0;
  }
  ASSERT_GE(pairs, 10);
  EXPECT_GE(right, pairs * 9 / 10);
  EXPECT_LE(good_and_off, std::max(1, pairs / 100));
  EXPECT_GT(right, right_at_once);
}

TEST(Starts, FromAnywhereLeadToTheRightPoseOrAreDoubted)
{
  int pairs = 0, right = 0;
  for (const made_pairs::Pair& pair : made_pairs::makeFarPairs("no scans", 1, 2)) {
    SCOPED_TRACE(pair.kind + " " + pair.clouds);
    const made_pairs::StartedPair found = made_pairs::started(pair, AlignmentOptions());
    ++pairs;
    right += found.isRight() ? 1 : 0;
    EXPECT_TRUE(found.isRight() || found.verdict() != Verdict::Good);
  }
  ASSERT_EQ(pairs, 9);
  EXPECT_GE(right, 8);
}

} // namespace
} // namespace pcl_gpu_icp::cli
