// Stage 2 alone: every point less its cloud's centroid.
#include "stages/demean.h"

#include "stage_rig.h"

namespace pcl_gpu_icp::test {

using stages::Demean;

TEST(DemeanRequest, IsOneWorkItemAPoint)
{
  EXPECT_EQ(Demean::request(10).stage, "demean");
  EXPECT_EQ(Demean::request(10).work_items, std::vector<std::size_t>{10});
}

class DemeanStage : public OnDevice {};

TEST_P(DemeanStage, SubtractsTheCentroidsOfTheSolution)
{
  StageRig rig(GetParam());
  Demean demean;
  for (const std::size_t n : GetParam().sizes()) {
    SCOPED_TRACE(n);
    Random random(2000 + n);
    const Cloud clouds[2] = {random.cloud(n), random.cloud(n, {5, 5, 5}, {-7, 0, 2})};
    rig.writePairs(clouds[0], clouds[1]);
    RigidSolution<double> record{};
    store(Eigen::Vector3d(1, -2, 3), record.source_centroid);
    store(Eigen::Vector3d(-7, 0.5, 2), record.target_centroid);
    rig.writeSolution(record);
    demean.enqueue(rig.queue, rig.pairs, rig.realBytes(), rig.solution);
    const std::size_t stride = rig.pairs.stride;
    const auto rows = rig.readReals(demean.demeaned(), PAIR_ROWS * stride);
    double worst = 0;
    for (int row = 0; row < PAIR_ROWS; ++row) {
      const double mean = row < 3 ? record.source_centroid[row] : record.target_centroid[row - 3];
      for (std::size_t i = 0; i < n; ++i)
        worst = std::max(worst, std::abs(rows[row * stride + i] - (clouds[row / 3](row % 3, i) - mean)));
      for (std::size_t i = n; i < stride; ++i)
        EXPECT_EQ(rows[row * stride + i], 0) << "padding of row " << row;
    }
    EXPECT_LE(worst, 10 * GetParam().epsilon());
  }
}

TEST_P(DemeanStage, IsOneCommand)
{
  if (GetParam().inPasses())
    GTEST_SKIP() << "each pass is a command";
  StageRig rig(GetParam());
  Demean demean;
  Random random(1);
  rig.writePairs(random.cloud(300), random.cloud(300));
  rig.writeSolution({});
  rig.queue.takeProfile();
  demean.enqueue(rig.queue, rig.pairs, rig.realBytes(), rig.solution);
  EXPECT_EQ(rig.queue.takeProfile().entries.at("demean").count, 1U);
}

RUN_WITH_EVERY_KERNEL(DemeanStage);

} // namespace pcl_gpu_icp::test
