// getResult().uncertainty: against the spread of noisy alignments, and what noise leaves undetermined.
#include "icp_on_hills.h"

#include <pcl_gpu_icp/batch.h>
#include <pcl_gpu_icp/gicp.h>

#include <pcl/search/kdtree.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <random>

namespace pcl_gpu_icp::test {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

Matrix6 matrixOf(const std::array<double, 36>& row_major)
{
  return Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(row_major.data());
}

Cloud::Ptr noisy(const Cloud& cloud, double sigma, std::mt19937& generator)
{
  std::normal_distribution<float> noise(0, static_cast<float>(sigma));
  Cloud::Ptr result(new Cloud(cloud));
  for (PointXYZ& point : *result) {
    point.x += noise(generator);
    point.y += noise(generator);
    point.z += noise(generator);
  }
  return result;
}

/// As turns about `centre`, and shifts.
Vector6 smallMotion(const RigidTransform& transform, const std::array<double, 3>& centre)
{
  const auto& r = transform.rotation;
  const auto image = transform(centre[0], centre[1], centre[2]);
  Vector6 motion;
  motion << (r[7] - r[5]) / 2, (r[2] - r[6]) / 2, (r[3] - r[1]) / 2, image[0] - centre[0], image[1] - centre[1],
      image[2] - centre[2];
  return motion;
}

struct Spread {
  Matrix6 covariance = Matrix6::Zero(); ///< of the answers
  Matrix6 claimed = Matrix6::Zero();    ///< the mean of what they say
};

using Configure = std::function<void(Icp&)>;

/// Of 500 alignments of a surface with itself, each with noise of its own.
Spread spreadOf(const Configure& configure, std::size_t clutter = 0)
{
  constexpr int trials = 500;
  constexpr double sigma = 0.002; // where neighbours are 0.2 apart
  const auto surface = scenes::hills<PointXYZ>(400);
  std::mt19937 generator(7);
  std::uniform_real_distribution<float> above(0.1F, 0.3F);
  BatchAligner batch;
  for (int trial = 0; trial < trials; ++trial) {
    const Cloud::Ptr from = noisy(*surface, sigma, generator), onto = noisy(*surface, sigma, generator);
    for (std::size_t i = 0; i < clutter; ++i)
      (*from)[i].z += above(generator);
    batch.add<PointXYZ, PointXYZ>(from, onto, configure);
  }
  Spread spread;
  for (const BatchResult& result : batch.run()) {
    EXPECT_TRUE(result.alignment.uncertainty) << result.alignment.message;
    if (!result.alignment.uncertainty)
      return spread;
    const Uncertainty& uncertainty = *result.alignment.uncertainty;
    const Vector6 off = smallMotion(result.transform, uncertainty.centre);
    spread.covariance += off * off.transpose() / trials;
    spread.claimed += matrixOf(uncertainty.covariance) / trials;
    EXPECT_EQ(uncertainty.free_motions, 0);
  }
  return spread;
}

/// In every direction: the least and the greatest deviation over what is claimed.
std::pair<double, double> ratios(const Spread& spread)
{
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6> solver(spread.covariance, spread.claimed);
  return {std::sqrt(solver.eigenvalues()[0]), std::sqrt(solver.eigenvalues()[5])};
}

constexpr Metric metrics[] = {Metric::Point, Metric::Plane, Metric::Symmetric, Metric::Generalized};

TEST(UncertaintyOfAnAnswer, IsTheSpreadOfNoisyAlignments)
{
  for (const Metric metric : metrics) {
    SCOPED_TRACE(toString(metric));
    const auto [least, greatest] = ratios(spreadOf([metric](Icp& icp) {
      icp.setMetric(metric);
      icp.setMaximumIterations(10);
    }));
    EXPECT_GT(least, 0.5);
    EXPECT_LT(greatest, 2);
    RecordProperty(toString(metric), std::to_string(least) + " to " + std::to_string(greatest));
  }
}

TEST(UncertaintyOfAnAnswer, IsTheSpreadWithALossAndClutter)
{
  for (const Metric metric : metrics) {
    SCOPED_TRACE(toString(metric));
    const auto [least, greatest] = ratios(spreadOf(
        [metric](Icp& icp) {
          icp.setMetric(metric);
          icp.setLoss({LossFunction::Tukey});
          icp.setMaximumIterations(20);
        },
        80));
    EXPECT_GT(least, 0.5);
    EXPECT_LT(greatest, 2);
    RecordProperty(toString(metric), std::to_string(least) + " to " + std::to_string(greatest));
  }
}

TEST(UncertaintyOfAnAnswer, HasTheSumsOfItsPairs)
{
  const auto target = scenes::hills<PointXYZ>(2000);
  const auto source = scenes::moved(*scenes::hills<PointXYZ>(1500, 2), scenes::smallMotion());
  // The matcher's own pairs, those that a rejector leaves, and those of a search method of the caller's.
  for (const bool reciprocal : {false, true})
    for (const bool callers_search : {false, true}) {
      SCOPED_TRACE(std::to_string(reciprocal) + std::to_string(callers_search));
      struct Open : Icp {
        const pcl::Correspondences& pairs() const { return *this->correspondences_; }
      } icp;
      icp.setUseReciprocalCorrespondences(reciprocal);
      if (callers_search)
        icp.setSearchMethodTarget(pcl::make_shared<pcl::search::KdTree<PointXYZ>>());
      icp.setMaximumIterations(100);
      icp.setInputSource(source);
      icp.setInputTarget(target);
      Cloud output;
      icp.align(output);
      ASSERT_TRUE(icp.getResult().uncertainty);
      const Uncertainty& found = *icp.getResult().uncertainty;
      const Eigen::Map<const Eigen::Vector3d> centre(found.centre.data());
      Matrix6 information = Matrix6::Zero();
      double squares = 0;
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (const pcl::Correspondence& c : icp.pairs()) {
        const Eigen::Vector3d p = output[c.index_query].getVector3fMap().cast<double>(), x = p - centre;
        Eigen::Matrix<double, 3, 6> J;
        J << 0, x[2], -x[1], 1, 0, 0, -x[2], 0, x[0], 0, 1, 0, x[1], -x[0], 0, 0, 0, 1;
        information += J.transpose() * J;
        squares += (p - (*target)[c.index_match].getVector3fMap().cast<double>()).squaredNorm();
        mean += p;
      }
      const auto n = static_cast<double>(icp.getResult().inliers);
      EXPECT_LT((mean / n - centre).norm(), 1e-5);
      EXPECT_LT((matrixOf(found.information) - information).norm(), 1e-4 * information.norm());
      EXPECT_NEAR(found.sigma, std::sqrt(squares / (3 * n - 6)), 1e-4 * found.sigma);
      const Matrix6 covariance = found.sigma * found.sigma * information.inverse();
      EXPECT_LT((matrixOf(found.covariance) - covariance).norm(), 1e-3 * covariance.norm());
      ASSERT_EQ(found.shifts.size(), 3U);
      ASSERT_EQ(found.turns.size(), 3U);
      for (const Uncertainty::Axis& axis : found.turns) {
        const Eigen::Map<const Eigen::Vector3d> direction(axis.direction.data());
        EXPECT_NEAR(axis.deviation,
                    std::sqrt(direction.dot(covariance.topLeftCorner<3, 3>() * direction)),
                    1e-3 * axis.deviation);
      }
      EXPECT_LE(found.turns[0].deviation, found.turns[2].deviation);
    }
}

/// Points of flat patches with noise.
class Patches {
public:
  explicit Patches(double noise, unsigned seed)
  : noise_(0, static_cast<float>(noise))
  , generator_(seed)
  {
  }

  /// A rectangle from `corner` along two edges.
  void
  add(const Eigen::Vector3f& corner, const Eigen::Vector3f& first, const Eigen::Vector3f& second, std::size_t points)
  {
    std::uniform_real_distribution<float> share(0, 1);
    const Eigen::Vector3f normal = first.cross(second).normalized();
    for (std::size_t i = 0; i < points; ++i) {
      PointXYZ point;
      point.getVector3fMap() =
          corner + share(generator_) * first + share(generator_) * second + noise_(generator_) * normal;
      cloud->push_back(point);
    }
  }

  Cloud::Ptr cloud{new Cloud};

private:
  std::normal_distribution<float> noise_;
  std::mt19937 generator_;
};

Cloud::Ptr ground(double noise, unsigned seed)
{
  Patches patches(noise, seed);
  patches.add({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, 3000);
  return patches.cloud;
}

Cloud::Ptr corridor(double noise, unsigned seed, bool with_end = false)
{
  Patches patches(noise, seed);
  patches.add({-5, -1, 0}, {10, 0, 0}, {0, 2, 0}, 2000);
  patches.add({-5, -1, 0}, {10, 0, 0}, {0, 0, 2}, 2000);
  patches.add({-5, 1, 0}, {10, 0, 0}, {0, 0, 2}, 2000);
  if (with_end)
    patches.add({5, -1, 0}, {0, 2, 0}, {0, 0, 2}, 400);
  return patches.cloud;
}

AlignmentResult resultOf(const Cloud::Ptr& source, const Cloud::Ptr& target, Metric metric, Motions motions)
{
  Icp icp;
  icp.setMetric(metric);
  icp.setMotions(motions);
  icp.setMaximumIterations(10);
  icp.setInputSource(source);
  icp.setInputTarget(target);
  Cloud output;
  icp.align(output);
  return icp.getResult();
}

/// The directions of those that are not determined.
std::vector<Eigen::Vector3d> undetermined(const std::vector<Uncertainty::Axis>& axes)
{
  std::vector<Eigen::Vector3d> directions;
  for (const Uncertainty::Axis& axis : axes)
    if (std::isinf(axis.deviation))
      directions.emplace_back(axis.direction[0], axis.direction[1], axis.direction[2]);
  return directions;
}

TEST(WhatNoiseLeavesUndetermined, IsNamed)
{
  for (const Metric metric : {Metric::Plane, Metric::Generalized})
    for (const double noise : {0.0, 1e-7, 1e-4, 0.01, 0.03}) {
      SCOPED_TRACE(toString(metric) + std::string(", ") + std::to_string(noise));
      const AlignmentResult flat = resultOf(ground(noise, 1), ground(noise, 2), metric, Motions::Rigid);
      EXPECT_EQ(flat.degeneracy, Degeneracy::Sliding);
      EXPECT_EQ(flat.free_motions, 3);
      ASSERT_TRUE(flat.uncertainty);
      EXPECT_EQ(undetermined(flat.uncertainty->shifts).size(), 2U);
      for (const auto& along : undetermined(flat.uncertainty->shifts))
        EXPECT_LT(std::abs(along.z()), 0.1);
      ASSERT_EQ(undetermined(flat.uncertainty->turns).size(), 1U);
      EXPECT_GT(undetermined(flat.uncertainty->turns)[0].z(), 0.99);

      const AlignmentResult straight = resultOf(corridor(noise, 1), corridor(noise, 2), metric, Motions::Rigid);
      EXPECT_EQ(straight.free_motions, 1);
      ASSERT_TRUE(straight.uncertainty);
      ASSERT_EQ(undetermined(straight.uncertainty->shifts).size(), 1U);
      EXPECT_GT(undetermined(straight.uncertainty->shifts)[0].x(), 0.99);
      EXPECT_TRUE(undetermined(straight.uncertainty->turns).empty());

      const AlignmentResult closed =
          resultOf(corridor(noise, 1, true), corridor(noise, 2, true), metric, Motions::Rigid);
      EXPECT_EQ(closed.degeneracy, Degeneracy::None);
      ASSERT_TRUE(closed.uncertainty);
      EXPECT_EQ(closed.uncertainty->free_motions, 0);
    }
}

TEST(WhatNoiseLeavesUndetermined, LeavesTheRestAsTheCovarianceHasIt)
{
  const Eigen::Affine3f tilt(Eigen::AngleAxisf(0.7F, Eigen::Vector3f(1, 2, 3).normalized()));
  const Cloud::Ptr source = scenes::moved(*corridor(0.01, 1), tilt), target = scenes::moved(*corridor(0.01, 2), tilt);
  for (const Metric metric : {Metric::Plane, Metric::Generalized}) {
    SCOPED_TRACE(toString(metric));
    const AlignmentResult result = resultOf(source, target, metric, Motions::Rigid);
    ASSERT_TRUE(result.uncertainty);
    EXPECT_EQ(undetermined(result.uncertainty->shifts).size(), 1U);
    const Matrix6 covariance = matrixOf(result.uncertainty->covariance);
    const auto expect = [&](const std::vector<Uncertainty::Axis>& axes, const Eigen::Matrix3d& block) {
      for (const Uncertainty::Axis& axis : axes) {
        const Eigen::Map<const Eigen::Vector3d> direction(axis.direction.data());
        EXPECT_NEAR(direction.norm(), 1, 1e-9);
        if (std::isfinite(axis.deviation)) {
          EXPECT_NEAR(axis.deviation, std::sqrt(direction.dot(block * direction)), 1e-6 * axis.deviation);
        }
      }
    };
    expect(result.uncertainty->turns, covariance.topLeftCorner<3, 3>());
    expect(result.uncertainty->shifts, covariance.bottomRightCorner<3, 3>());
  }
}

TEST(WhatNoiseLeavesUndetermined, IsKeptAsTheGuessHasItOnRequest)
{
  // Along the corridor's own axis, wherever that points to.
  const Eigen::Affine3f tilt(Eigen::AngleAxisf(0.7F, Eigen::Vector3f(1, 2, 3).normalized()));
  const Eigen::Vector3d along = tilt.linear().cast<double>().col(0);
  const Cloud::Ptr source = scenes::moved(*corridor(0.01, 1), tilt), target = scenes::moved(*corridor(0.01, 2), tilt);
  Eigen::Matrix4d guess = Eigen::Matrix4d::Identity();
  guess.topLeftCorner<3, 3>() = Eigen::AngleAxisd(0.01, Eigen::Vector3d(1, 1, 0).normalized()).toRotationMatrix();
  guess.topRightCorner<3, 1>() = 0.2 * along + Eigen::Vector3d(0.02, -0.01, 0.03);
  for (const Metric metric : {Metric::Plane, Metric::Generalized})
    for (const bool kept : {false, true}) {
      SCOPED_TRACE(toString(metric) + std::to_string(kept));
      IterativeClosestPoint<PointXYZ, PointXYZ, double> icp;
      icp.setMetric(metric);
      icp.setKeepUndetermined(kept);
      icp.setMaximumIterations(30);
      icp.setInputSource(source);
      icp.setInputTarget(target);
      Cloud output;
      icp.align(output, guess);
      const AlignmentResult& result = icp.getResult();
      ASSERT_TRUE(result.uncertainty);
      EXPECT_EQ(result.free_motions, 1);
      const Eigen::Matrix4d found = icp.getFinalTransformation();
      // How far the middle of the corridor moved, and how far the guess had it moved.
      const Eigen::Vector3d middle =
          found.inverse().topLeftCorner<3, 3>() *
          (Eigen::Map<const Eigen::Vector3d>(result.uncertainty->centre.data()) - found.topRightCorner<3, 1>());
      const auto at = [&](const Eigen::Matrix4d& pose) -> Eigen::Vector3d {
        return pose.topLeftCorner<3, 3>() * middle + pose.topRightCorner<3, 1>();
      };
      const double off = along.dot(at(found) - at(guess));
      if (kept) {
        EXPECT_NEAR(off, 0, 2e-3);
        // Of the pairs there.
        EXPECT_NEAR(result.rmse * result.rmse, icp.getFitnessScore(), 1e-6);
      }
      else {
        EXPECT_GT(std::abs(off), 5e-3);
      }
      // The rest is the corridor's.
      const Eigen::Vector3d across = at(found) - middle - along * along.dot(at(found) - middle);
      EXPECT_LT(across.norm(), 3e-3);
      EXPECT_LT(scenes::degreesBetween<double>(found, Eigen::Matrix4d::Identity()), 0.2);
    }
}

TEST(WhatNoiseLeavesUndetermined, IsSaidOfALossThatLeavesNothingToo)
{
  Icp icp;
  icp.setMetric(Metric::Plane);
  icp.setLoss({LossFunction::Tukey, 1e-7});
  icp.setMaximumIterations(5);
  icp.setInputSource(corridor(0.01, 1));
  icp.setInputTarget(corridor(0.01, 2));
  Cloud output;
  icp.align(output);
  const AlignmentResult& result = icp.getResult();
  ASSERT_TRUE(result.uncertainty) << result.message;
  EXPECT_GT(result.free_motions, 0);
  for (const double entry : result.uncertainty->covariance)
    EXPECT_TRUE(std::isfinite(entry));
}

TEST(WhatNoiseLeavesUndetermined, IsEverythingWithoutCovariances)
{
  // Distributions that are points: their information has no bound, and nothing is noise.
  using Gicp = GeneralizedIterativeClosestPoint<PointXYZ, PointXYZ>;
  const auto target = scenes::hills<PointXYZ>(500);
  const auto covariances = [](const Cloud& cloud, double size) {
    Gicp::MatricesVectorPtr matrices(new Gicp::MatricesVector);
    matrices->assign(cloud.size(), Eigen::Matrix3d::Identity() * size);
    return matrices;
  };
  Gicp gicp;
  gicp.setInputSource(target);
  gicp.setInputTarget(target);
  gicp.setSourceCovariances(covariances(*target, 1));
  gicp.setTargetCovariances(covariances(*target, 0));
  Cloud output;
  gicp.align(output);
  ASSERT_TRUE(gicp.getResult().uncertainty) << gicp.getResult().message;
  EXPECT_EQ(gicp.getResult().uncertainty->free_motions, gicp.getResult().free_motions);
}

TEST(WhatNoiseLeavesUndetermined, IsOfTheMotionsAllowed)
{
  // Along the corridor is the only way that is not held, and no way that may be gone.
  const Cloud::Ptr source = ground(0.01, 1), target = ground(0.01, 2);
  const AlignmentResult planar = resultOf(source, target, Metric::Plane, Motions::Planar);
  EXPECT_EQ(planar.free_motions, 3);
  const AlignmentResult rigid = resultOf(corridor(0.01, 1), corridor(0.01, 2), Metric::Point, Motions::Yaw);
  ASSERT_TRUE(rigid.uncertainty);
  ASSERT_EQ(rigid.uncertainty->turns.size(), 1U);
  EXPECT_EQ(rigid.uncertainty->turns[0].direction, (std::array<double, 3>{0, 0, 1}));
  EXPECT_EQ(rigid.uncertainty->shifts.size(), 3U);
  const Matrix6 covariance = matrixOf(rigid.uncertainty->covariance);
  EXPECT_EQ(covariance.topRows<2>().norm(), 0);
}

TEST(WhatFewPairsLeaveUndetermined, IsNamed)
{
  Cloud::Ptr line(new Cloud);
  for (int i = 0; i < 50; ++i)
    line->push_back({static_cast<float>(i), 2 * static_cast<float>(i), 0});
  const AlignmentResult on_a_line = resultOf(line, line, Metric::Point, Motions::Rigid);
  EXPECT_EQ(on_a_line.degeneracy, Degeneracy::Line);
  ASSERT_TRUE(on_a_line.uncertainty);
  EXPECT_EQ(on_a_line.uncertainty->free_motions, 1);
  const auto free = undetermined(on_a_line.uncertainty->turns);
  ASSERT_EQ(free.size(), 1U);
  EXPECT_LT((free[0] - Eigen::Vector3d(1, 2, 0).normalized()).norm(), 1e-5);
  EXPECT_TRUE(undetermined(on_a_line.uncertainty->shifts).empty());

  Icp robust;
  robust.setLoss({LossFunction::Cauchy, 1});
  robust.setInputSource(line);
  robust.setInputTarget(line);
  Cloud output;
  robust.align(output);
  EXPECT_EQ(robust.getResult().degeneracy, Degeneracy::Line);

  Cloud::Ptr two(new Cloud);
  two->push_back({0, 0, 0});
  two->push_back({1, 0, 0});
  EXPECT_FALSE(resultOf(two, line, Metric::Point, Motions::Rigid).uncertainty);
}

} // namespace
} // namespace pcl_gpu_icp::test
