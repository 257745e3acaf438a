// Stage 4 alone: H = U S V^T for every kind of H.
#include "stages/svd.h"

#include "stage_rig.h"

#include <Eigen/SVD>

namespace pcl_gpu_icp::test {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(SvdRequest, IsTwentySevenThenNineThenOne)
{
  EXPECT_EQ(stages::Svd::request().stage, "svd");
  EXPECT_EQ(stages::Svd::request().work_items, (std::vector<std::size_t>{27, 9, 1}));
}

class SvdStage : public OnDevice {
protected:
  struct Decomposition {
    Matrix3d U;
    Vector3d S;
    Matrix3d V;
    int rank;
  };

  Decomposition decompose(const Matrix3d& H, float resolution_sq = 0)
  {
    RigidSolution<double> record{};
    store(H, record.H);
    rig_.writeSolution(record);
    rig_.pairs.count = 1;
    rig_.pairs.resolution_sq = resolution_sq;
    stage_.enqueue(rig_.queue, rig_.pairs, rig_.solution);
    const auto solution = rig_.readSolution();
    return {matrixOf(solution.U), vectorOf(solution.S), matrixOf(solution.V), solution.rank};
  }

  /// Everything that makes a decomposition one, for any H.
  void expectDecomposes(const Matrix3d& H)
  {
    SCOPED_TRACE(testing::Message() << "H =\n" << H);
    const Decomposition result = decompose(H);
    const double epsilon = GetParam().epsilon();
    const Vector3d S = result.S;
    ASSERT_TRUE(result.U.allFinite() && S.allFinite() && result.V.allFinite());
    EXPECT_LE((result.U.transpose() * result.U - Matrix3d::Identity()).cwiseAbs().maxCoeff(), 16 * epsilon);
    EXPECT_LE((result.V.transpose() * result.V - Matrix3d::Identity()).cwiseAbs().maxCoeff(), 16 * epsilon);
    EXPECT_GE(S[0], S[1]);
    EXPECT_GE(S[1], S[2]);
    EXPECT_GE(S[2], 0);
    EXPECT_LE((result.U * S.asDiagonal() * result.V.transpose() - H).norm(), 16 * epsilon * H.norm());
    const Vector3d expected = Eigen::JacobiSVD<Matrix3d>(H).singularValues();
    EXPECT_LE((S - expected).cwiseAbs().maxCoeff(), 16 * epsilon * expected[0]);
  }

private:
  StageRig rig_{GetParam()};
  stages::Svd stage_;
};

TEST_P(SvdStage, DecomposesRandomMatrices)
{
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Matrix3d U = random.rotation(), V = random.rotation();
    const double a = random.uniform(0, 1), b = a * random.uniform(0, 1), c = b * random.uniform(-1, 1);
    expectDecomposes(U * Vector3d(a, b, c).asDiagonal() * V);
  }
}

TEST_P(SvdStage, DecomposesWhateverTheScale)
{
  Random random(7);
  const Matrix3d H = random.rotation() * Vector3d(3, 2, 1).asDiagonal() * random.rotation();
  for (const double scale : {1e-12, 1e-6, 1.0, 1e6, 1e12, 1e18})
    expectDecomposes(scale * H);
}

TEST_P(SvdStage, DecomposesDiagonalAndPermutedMatrices)
{
  Matrix3d permutation;
  permutation << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  for (const Vector3d& diagonal : {Vector3d(3, 2, 1), Vector3d(1, 2, 3), Vector3d(-1, 2, -3), Vector3d(0, 5, 0.5)}) {
    expectDecomposes(diagonal.asDiagonal());
    expectDecomposes(permutation * diagonal.asDiagonal());
  }
}

TEST_P(SvdStage, DecomposesEqualSingularValues)
{
  Random random(8);
  const Matrix3d rotation = random.rotation();
  expectDecomposes(Matrix3d::Identity());
  expectDecomposes(-Matrix3d::Identity());
  expectDecomposes(rotation);
  expectDecomposes(-5 * rotation);
  expectDecomposes(rotation * Vector3d(2, 2, 1).asDiagonal() * random.rotation());
  expectDecomposes(rotation * Vector3d(2, 1, 1).asDiagonal() * random.rotation());
}

TEST_P(SvdStage, DecomposesSmallSingularValues)
{
  Random random(9);
  for (const double smallest : {1e-3, 1e-5, 1e-7, 1e-9, 1e-15}) {
    expectDecomposes(random.rotation() * Vector3d(1, 0.5, smallest).asDiagonal() * random.rotation());
    expectDecomposes(random.rotation() * Vector3d(1, smallest, smallest / 2).asDiagonal() * random.rotation());
  }
}

TEST_P(SvdStage, NamesTheRank)
{
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Matrix3d U = random.rotation(), V = random.rotation();
    for (const int rank : {0, 1, 2, 3}) {
      Vector3d S(2, 1, 0.5);
      S.tail(3 - rank).setZero();
      const Matrix3d H = U * S.asDiagonal() * V;
      EXPECT_EQ(decompose(H).rank, rank);
      expectDecomposes(H);
    }
  }
}

TEST_P(SvdStage, CountsWhatIsBelowTheResolutionAsZero)
{
  const Matrix3d H = Vector3d(1, 1e-2, 1e-4).asDiagonal();
  EXPECT_EQ(decompose(H, 1e-5F).rank, 3);
  EXPECT_EQ(decompose(H, 1e-3F).rank, 2);
  EXPECT_EQ(decompose(H, 1e-1F).rank, 1);
  EXPECT_EQ(decompose(H, 10).rank, 0);
}

TEST_P(SvdStage, OfZeroIsTheIdentity)
{
  const Decomposition result = decompose(Matrix3d::Zero());
  EXPECT_EQ(result.U, Matrix3d::Identity());
  EXPECT_EQ(result.V, Matrix3d::Identity());
  EXPECT_EQ(result.S, Vector3d::Zero());
}

// Of rank 1, u v^T: what turns u into v by the smallest angle.
TEST_P(SvdStage, LeavesWhatALineLeavesOpenAsItWas)
{
  const auto expectSmallestTurn = [&](const Vector3d& u, const Vector3d& v) {
    SCOPED_TRACE(testing::Message() << "from " << u.transpose() << " to " << v.transpose());
    const Matrix3d H = u * v.transpose();
    const Decomposition result = decompose(H);
    EXPECT_EQ(result.rank, 1);
    expectDecomposes(H);
    Matrix3d R = result.V * result.U.transpose();
    if (R.determinant() < 0)
      R = result.V * Vector3d(1, 1, -1).asDiagonal() * result.U.transpose();
    const double tolerance = 32 * GetParam().epsilon();
    EXPECT_LE((R * u - v).norm(), tolerance);
    EXPECT_NEAR((R.trace() - 1) / 2, u.dot(v), tolerance);
  };
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY();
  expectSmallestTurn(x, x);
  expectSmallestTurn(x, y);
  expectSmallestTurn(x, -x);
  expectSmallestTurn(-y, y);
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    const Vector3d u = random.direction(), v = random.direction();
    expectSmallestTurn(u, v);
    expectSmallestTurn(u, u);
    expectSmallestTurn(u, -u);
  }
  // Close to half a turn, where the axis of the turn is all but lost: exactly representable directions, since a
  // rounding of them would turn them by more.
  for (const double off : {1e-3, 1e-5, 1e-8, 1e-16, 1e-20, 1e-22, 1e-30, 1e-40, 1e-160, 1e-200}) {
    SCOPED_TRACE(off);
    expectDecomposes(x * Vector3d(-1, off, 0).transpose());
    expectDecomposes(Vector3d(-1, off, 0) * x.transpose());
    expectDecomposes(Vector3d(-1, off, off) * Vector3d(1, -off, off).transpose());
  }
}

RUN_WITH_EVERY_KERNEL(SvdStage);

} // namespace pcl_gpu_icp::test
