// Gather alone: pairs from two resident clouds, their matches and a pose.
#include "stages/gather.h"

#include "stage_rig.h"
#include "stages/pack.h"

namespace pcl_gpu_icp::test {

using stages::Gather;

class GatherStage : public OnDevice {};

TEST_P(GatherStage, PairsTheMovedSourceWithTheTarget)
{
  StageRig rig(GetParam());
  Gather gather;
  for (const std::size_t n : GetParam().sizes(20'000)) {
    SCOPED_TRACE(n);
    Random random(6000 + n);
    const Cloud clouds[2] = {random.cloud(n + 5), random.cloud(n / 2 + 1)};
    stages::Cloud source, target;
    stages::packCloud(rig.queue, viewOf(clouds[0]), {}, source);
    stages::packCloud(rig.queue, viewOf(clouds[1]), {}, target);
    std::vector<Correspondence> matches(n);
    for (Correspondence& match : matches)
      match = {std::int32_t(random.count(0, n + 4)), std::int32_t(random.count(0, n / 2)), 0};
    const Eigen::Isometry3d pose = random.motion(5);

    gather.enqueue(rig.queue, source, target, matches.data(), n, transformOf(pose), rig.pairs);
    ASSERT_EQ(rig.pairs.count, n);
    const std::size_t stride = rig.pairs.stride;
    const auto rows = rig.readFloats(rig.pairs.rows, PAIR_ROWS * stride);
    double worst = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const Eigen::Vector3d p = pose * Eigen::Vector3d(clouds[0].col(matches[k].source).cast<double>());
      for (int axis = 0; axis < 3; ++axis) {
        worst = std::max(worst, std::abs(rows[axis * stride + k] - p[axis]));
        ASSERT_EQ(rows[(3 + axis) * stride + k], clouds[1](axis, matches[k].target));
      }
    }
    EXPECT_LE(worst, 1e-5);
    for (int row = 0; row < PAIR_ROWS; ++row)
      for (std::size_t k = n; k < stride; ++k)
        ASSERT_EQ(rows[row * stride + k], 0) << "padding of row " << row;
  }
}

RUN_WITH_EVERY_KERNEL(GatherStage);

} // namespace pcl_gpu_icp::test
