// The kernels of listed pairs alone: every value of the five stages from one pass over the pairs.
#include "stages/listed_pairs.h"

#include "stage_rig.h"

namespace pcl_gpu_icp::test {

using Eigen::Matrix3d;
using stages::ListedPairs;

class OnePass : public OnDevice {
protected:
  RigidSolution<double> solve(const Cloud& source, const Cloud& target)
  {
    rig_.writePairs(source, target);
    rig_.writeSolution({});
    listed_.enqueue(rig_.queue, rig_.pairs, rig_.realBytes(), rig_.solution);
    return rig_.readSolution();
  }

  StageRig rig_{GetParam()};
  ListedPairs listed_;
};

TEST_P(OnePass, LeaveWhatEveryStageWouldHaveLeft)
{
  for (const std::size_t n : GetParam().sizes()) {
    SCOPED_TRACE(n);
    Random random(4000 + n);
    const Cloud source = random.cloud(n, {10, 6, 3}, {1, -2, 0.5});
    const Cloud target = moved(source, random.motion(2));
    const auto solution = solve(source, target);
    const Reference expected = referenceOf(source, target);
    const double epsilon = GetParam().epsilon();
    EXPECT_LE((vectorOf(solution.source_centroid) - expected.source_centroid).cwiseAbs().maxCoeff(), 64 * epsilon * 10);
    EXPECT_LE((vectorOf(solution.target_centroid) - expected.target_centroid).cwiseAbs().maxCoeff(), 64 * epsilon * 10);
    const double magnitude = double(n) * 10 * 10;
    EXPECT_LE((matrixOf(solution.H) - expected.H).cwiseAbs().maxCoeff(), 64 * epsilon * magnitude);
    EXPECT_LE((vectorOf(solution.S) - expected.S).cwiseAbs().maxCoeff(), 64 * epsilon * magnitude);
    const Matrix3d U = matrixOf(solution.U), V = matrixOf(solution.V), R = matrixOf(solution.R);
    EXPECT_LE((U * vectorOf(solution.S).asDiagonal() * V.transpose() - matrixOf(solution.H)).norm(),
              32 * epsilon * magnitude);
    EXPECT_NEAR(R.determinant(), 1, 16 * epsilon);
    EXPECT_LE(
        (vectorOf(solution.t) - (vectorOf(solution.target_centroid) - R * vectorOf(solution.source_centroid))).norm(),
        64 * epsilon * 10);
    if (n > 3) {
      EXPECT_LE((R - expected.R).cwiseAbs().maxCoeff(), 64 * epsilon);
    }
  }
}

TEST_P(OnePass, CountEveryPairOnce)
{
  for (const std::size_t n : GetParam().sizes(5000)) {
    SCOPED_TRACE(n);
    Cloud source = Cloud::Zero(3, n), target = Cloud::Zero(3, n);
    for (std::size_t i = 0; i < n; ++i) {
      source.col(i) = Eigen::Vector3f(float(i % 2), float(i % 3), 1);
      target.col(i) = Eigen::Vector3f(-1, float(i % 5), float(i % 2));
    }
    const auto solution = solve(source, target);
    EXPECT_EQ(solution.source_centroid[2], 1);
    EXPECT_EQ(solution.target_centroid[0], -1);
    EXPECT_NEAR(solution.source_centroid[1], source.row(1).cast<double>().mean(), 2 * GetParam().epsilon());
    EXPECT_NEAR(solution.target_centroid[1], target.row(1).cast<double>().mean(), 4 * GetParam().epsilon());
  }
}

TEST_P(OnePass, AreTwoCommands)
{
  if (GetParam().inPasses())
    GTEST_SKIP() << "each pass is a command";
  Random random(1);
  rig_.queue.takeProfile();
  solve(random.cloud(5000), random.cloud(5000));
  const auto entries = rig_.queue.takeProfile().entries;
  EXPECT_EQ(entries.at("listed_sums").count, 1U);
  EXPECT_EQ(entries.at("listed_solve").count, 1U);
}

RUN_WITH_EVERY_KERNEL(OnePass);

} // namespace pcl_gpu_icp::test
