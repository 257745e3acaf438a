// Stage 5 alone: R and t from centroids, U and V.
#include "stages/rigid_transform.h"

#include "stage_rig.h"

namespace pcl_gpu_icp::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using stages::RotationTranslation;

TEST(RotationTranslationRequest, IsTwentySevenThenNineThenThree)
{
  EXPECT_EQ(RotationTranslation::request().stage, "rigid_transform");
  EXPECT_EQ(RotationTranslation::request().work_items, (std::vector<std::size_t>{27, 9, 3}));
}

class RotationTranslationStage : public OnDevice {
protected:
  RigidSolution<double> solve(const Matrix3d& U, const Matrix3d& V, const Vector3d& p, const Vector3d& q)
  {
    RigidSolution<double> record{};
    store(U, record.U);
    store(V, record.V);
    store(p, record.source_centroid);
    store(q, record.target_centroid);
    rig_.writeSolution(record);
    RotationTranslation().enqueue(rig_.queue, rig_.solution);
    return rig_.readSolution();
  }

private:
  StageRig rig_{GetParam()};
};

TEST_P(RotationTranslationStage, TurnsAndMovesAndNeverReflects)
{
  const double tolerance = 8 * GetParam().epsilon();
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    Matrix3d U = random.rotation(), V = random.rotation();
    if (seed & 1)
      U.col(random.count(0, 2)) *= -1;
    if (seed & 2)
      V.col(random.count(0, 2)) *= -1;
    const Vector3d p = 3 * random.direction(), q = 2 * random.direction();
    const auto solution = solve(U, V, p, q);
    const double sign = U.determinant() * V.determinant() < 0 ? -1 : 1;
    const Matrix3d expected = V * Vector3d(1, 1, sign).asDiagonal() * U.transpose();
    const Matrix3d R = matrixOf(solution.R);
    EXPECT_LE((R - expected).cwiseAbs().maxCoeff(), tolerance);
    EXPECT_NEAR(R.determinant(), 1, tolerance);
    EXPECT_LE((vectorOf(solution.t) - (q - R * p)).cwiseAbs().maxCoeff(), 4 * tolerance);
  }
}

TEST_P(RotationTranslationStage, IsExactForTheIdentity)
{
  const auto solution = solve(Matrix3d::Identity(), Matrix3d::Identity(), {1, 2, 3}, {4, 4, 4});
  EXPECT_EQ(matrixOf(solution.R), Matrix3d::Identity());
  EXPECT_EQ(vectorOf(solution.t), Vector3d(3, 2, 1));
}

RUN_WITH_EVERY_KERNEL(RotationTranslationStage);

} // namespace pcl_gpu_icp::test
