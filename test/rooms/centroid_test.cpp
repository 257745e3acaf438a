// Stage 1 alone: what it requests, and the centroids it leaves on the device.
#include "stages/centroid.h"

#include "stage_rig.h"

namespace pcl_gpu_icp::test {

using stages::Centroid;

TEST(CentroidRequest, HalvesUntilOneIsLeft)
{
  EXPECT_EQ(Centroid::request(10).stage, "centroid");
  EXPECT_EQ(Centroid::request(10).work_items, (std::vector<std::size_t>{10, 5, 3, 2, 1}));
  EXPECT_EQ(Centroid::request(1024).work_items,
            (std::vector<std::size_t>{1024, 512, 256, 128, 64, 32, 16, 8, 4, 2, 1}));
  EXPECT_EQ(Centroid::request(2).work_items, (std::vector<std::size_t>{2, 1}));
  EXPECT_EQ(Centroid::request(1).work_items, std::vector<std::size_t>{1});
  EXPECT_EQ(Centroid::request(0).work_items, std::vector<std::size_t>{0});
}

class CentroidStage : public OnDevice {};

TEST_P(CentroidStage, LeavesBothCentroids)
{
  StageRig rig(GetParam());
  Centroid centroid;
  for (const std::size_t n : GetParam().sizes()) {
    SCOPED_TRACE(n);
    Random random(1000 + n);
    const Cloud source = random.cloud(n), target = random.cloud(n, {5, 5, 5}, {-7, 0, 2});
    rig.writePairs(source, target);
    rig.writeSolution({});
    centroid.enqueue(rig.queue, rig.pairs, rig.realBytes(), rig.solution);
    const auto solution = rig.readSolution();
    const Reference expected = referenceOf(source, target);
    // A pairwise sum loses no more than half a unit a level.
    const double tolerance = 12 * GetParam().epsilon() * (2 + std::log2(n));
    EXPECT_LE((vectorOf(solution.source_centroid) - expected.source_centroid).cwiseAbs().maxCoeff(), tolerance);
    EXPECT_LE((vectorOf(solution.target_centroid) - expected.target_centroid).cwiseAbs().maxCoeff(), tolerance);
  }
}

TEST_P(CentroidStage, SumsOfSmallIntegersAreExact)
{
  StageRig rig(GetParam());
  Centroid centroid;
  for (const std::size_t n : GetParam().sizes(2049)) {
    SCOPED_TRACE(n);
    Cloud source(3, n), target(3, n);
    for (std::size_t i = 0; i < n; ++i) {
      source.col(i) = Eigen::Vector3f(float(i % 7), float(i), 1);
      target.col(i) = Eigen::Vector3f(-1, -float(i), float(i % 2));
    }
    rig.writePairs(source, target);
    rig.writeSolution({});
    centroid.enqueue(rig.queue, rig.pairs, rig.realBytes(), rig.solution);
    const auto solution = rig.readSolution();
    EXPECT_EQ(solution.source_centroid[2], 1);
    EXPECT_EQ(solution.target_centroid[0], -1);
    EXPECT_EQ(solution.source_centroid[1], (n - 1) / 2.0);
    EXPECT_EQ(solution.target_centroid[1], -solution.source_centroid[1]);
  }
}

TEST_P(CentroidStage, LaunchesOnceForEachRequestOfTheReduction)
{
  if (GetParam().inPasses())
    GTEST_SKIP() << "each pass is a command";
  StageRig rig(GetParam());
  Centroid centroid;
  for (const std::size_t n : {1, 2, 3, 129, 2049}) {
    SCOPED_TRACE(n);
    Random random(n);
    rig.writePairs(random.cloud(n), random.cloud(n));
    rig.writeSolution({});
    rig.queue.takeProfile();
    centroid.enqueue(rig.queue, rig.pairs, rig.realBytes(), rig.solution);
    // The first request is the widening; the division by n comes on top.
    EXPECT_EQ(rig.queue.takeProfile().entries.at("centroid").count, Centroid::request(n).work_items.size() + 1);
  }
}

TEST_P(CentroidStage, ACloudThatShrinksLeavesNothingBehind)
{
  StageRig rig(GetParam());
  Centroid centroid;
  Random random(5);
  for (const std::size_t n : {200, 3}) {
    const Cloud source = random.cloud(n), target = random.cloud(n);
    rig.writePairs(source, target);
    rig.writeSolution({});
    centroid.enqueue(rig.queue, rig.pairs, rig.realBytes(), rig.solution);
    EXPECT_LE((vectorOf(rig.readSolution().source_centroid) - referenceOf(source, target).source_centroid).norm(),
              1e-4 * (GetParam().epsilon() / 1e-7));
  }
}

RUN_WITH_EVERY_KERNEL(CentroidStage);

} // namespace pcl_gpu_icp::test
