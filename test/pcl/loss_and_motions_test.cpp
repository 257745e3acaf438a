// setLoss() and setMotions() of the ICP classes: with every metric and search, alone and over listed pairs.
#include "icp_on_hills.h"

#include <pcl_gpu_icp/batch.h>
#include <pcl_gpu_icp/gicp.h>
#include <pcl_gpu_icp/icp_nl.h>
#include <pcl_gpu_icp/icp_with_normals.h>

#include <pcl/registration/correspondence_rejection_distance.h>
#include <pcl/registration/transformation_estimation_lm.h>
#include <pcl/search/kdtree.h>

#include <random>

namespace pcl_gpu_icp::test {
namespace {

constexpr Metric metrics[] = {Metric::Point, Metric::Plane, Metric::Symmetric, Metric::Generalized};
constexpr LossFunction functions[] = {
    LossFunction::Huber, LossFunction::Cauchy, LossFunction::GemanMcClure, LossFunction::Tukey, LossFunction::Welsch};

class LossAndMotions : public IcpOnHills {
protected:
  /// A quarter more points, which are not on the target.
  void addClutter()
  {
    std::mt19937 generator(5);
    std::uniform_real_distribution<float> across(-2, 0), above(0.3F, 0.6F);
    const std::size_t n = source->size() / 4;
    for (std::size_t i = 0; i < n; ++i) {
      PointXYZ point = (*source)[4 * i];
      point.z += above(generator);
      source->push_back(point);
    }
  }

  template <typename Scalar = float>
  static double degreesOff(const Eigen::Matrix<Scalar, 4, 4>& found)
  {
    const Eigen::Matrix<Scalar, 4, 4> truth = scenes::smallMotion().inverse().matrix().template cast<Scalar>();
    return scenes::degreesBetween<Scalar>(found, truth);
  }

  template <typename Aligner>
  Eigen::Matrix4f aligned(Aligner& aligner, const Eigen::Matrix4f& guess = identity)
  {
    aligner.setInputSource(source);
    aligner.setInputTarget(target);
    Cloud output;
    aligner.align(output, guess);
    EXPECT_TRUE(aligner.hasConverged()) << aligner.getResult().message;
    return aligner.getFinalTransformation();
  }
};

TEST_F(LossAndMotions, ALossKeepsClutterFromPulling)
{
  source = scenes::moved(*scenes::hills<PointXYZ>(2500), scenes::smallMotion()); // the target's own points
  addClutter();
  for (const Metric metric : metrics) {
    Icp plain;
    plain.setMaximumIterations(100);
    plain.setMetric(metric);
    const double without = degreesOff(aligned(plain));
    for (const LossFunction function : functions)
      for (const double scale : {0.0, metric == Metric::Generalized ? 3.0 : 0.1}) {
        SCOPED_TRACE(toString(metric) + std::string(", ") + toString(function) + ":" + std::to_string(scale));
        Icp robust;
        robust.setMaximumIterations(100);
        robust.setMetric(metric);
        robust.setLoss({function, scale});
        // Huber's weights end at no distance.
        EXPECT_LT(degreesOff(aligned(robust)), (function == LossFunction::Huber ? 0.9 : 0.5) * without);
        EXPECT_EQ(robust.getResult().loss.function, function);
        EXPECT_GT(robust.getResult().loss_scale, 0);
        if (scale > 0) {
          EXPECT_EQ(robust.getResult().loss_scale, scale);
        }
      }
  }
}

TEST_F(LossAndMotions, OverListedPairsIsTheSame)
{
  for (const Metric metric : metrics)
    for (const Motions motions : {Motions::Rigid, Motions::Yaw}) {
      SCOPED_TRACE(toString(metric) + std::string(", ") + toString(motions));
      Icp fused, listed, staged, device;
      const auto all = pcl::make_shared<pcl::registration::CorrespondenceRejectorDistance>();
      all->setMaximumDistance(100);
      listed.addCorrespondenceRejector(all);
      staged.setPipeline(Pipeline::Staged);
      device.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree);
      for (Icp* aligner : {&fused, &listed, &staged, &device}) {
        aligner->setMetric(metric);
        aligner->setLoss({LossFunction::Cauchy, 0.05});
        aligner->setMotions(motions);
        aligner->setMaximumIterations(10);
      }
      const Eigen::Matrix4f expected = aligned(fused);
      EXPECT_LT((aligned(listed) - expected).norm(), 1e-6);
      EXPECT_LT((aligned(staged) - expected).norm(), 1e-6);
      EXPECT_LT((aligned(device) - expected).norm(), 1e-5);
      Icp reciprocal;
      reciprocal.setMetric(metric);
      reciprocal.setLoss({LossFunction::Cauchy, 0.05});
      reciprocal.setMotions(motions);
      reciprocal.setUseReciprocalCorrespondences(true);
      reciprocal.setMaximumIterations(10);
      aligned(reciprocal);
      EXPECT_LT(reciprocal.getResult().inliers, source->size());
    }
}

TEST_F(LossAndMotions, AnEndlessScaleIsNone)
{
  const auto all = pcl::make_shared<pcl::registration::CorrespondenceRejectorDistance>();
  all->setMaximumDistance(100);
  for (const Metric metric : metrics)
    for (const bool listed : {false, true}) {
      SCOPED_TRACE(toString(metric) + std::to_string(listed));
      Icp plain, endless;
      for (Icp* aligner : {&plain, &endless}) {
        aligner->setMetric(metric);
        aligner->setMaximumIterations(5);
        if (listed)
          aligner->addCorrespondenceRejector(all);
      }
      endless.setLoss({LossFunction::Huber, std::numeric_limits<double>::infinity()});
      EXPECT_EQ(aligned(endless), aligned(plain));
      ASSERT_TRUE(endless.getResult().uncertainty);
      EXPECT_EQ(endless.getResult().uncertainty->covariance, plain.getResult().uncertainty->covariance);
    }
  Icp with_search;
  with_search.setSearchMethodTarget(pcl::make_shared<pcl::search::KdTree<PointXYZ>>());
  with_search.setLoss({LossFunction::Huber, std::numeric_limits<double>::infinity()});
  aligned(with_search);
}

TEST_F(LossAndMotions, InABatchAreTheBitsOfAlone)
{
  const auto configure = [](auto& aligner) {
    aligner.setMaximumIterations(10);
    aligner.setMetric(Metric::Plane);
    aligner.setLoss({LossFunction::Tukey});
    aligner.setMotions(Motions::Planar);
  };
  configure(icp);
  const Eigen::Matrix4f alone = aligned(icp);
  BatchAligner batch;
  for (int pair = 0; pair < 6; ++pair)
    if (pair % 2 == 0)
      batch.add<PointXYZ, PointXYZ>(source, target, configure);
    else
      batch.add<PointXYZ, PointXYZ>(source, target, twenty_iterations);
  const auto results = batch.run();
  Icp plain;
  twenty_iterations(plain);
  const Eigen::Matrix4f without = aligned(plain);
  for (int pair = 0; pair < 6; ++pair)
    EXPECT_EQ(toMatrix(results[pair].transform), pair % 2 == 0 ? alone : without) << pair;
}

TEST_F(LossAndMotions, EveryClassHasThem)
{
  const Eigen::Affine3f turn(Eigen::Translation3f(0.05F, -0.04F, 0) *
                             Eigen::AngleAxisf(0.06F, Eigen::Vector3f::UnitZ()));
  source = scenes::moved(*scenes::hills<PointXYZ>(2500), turn);
  const auto check = [&](auto& aligner) {
    aligner.setMaximumIterations(60);
    aligner.setMotions(Motions::Planar);
    aligner.setLoss({LossFunction::Cauchy});
    const Eigen::Matrix4f found = aligned(aligner);
    EXPECT_LT(scenes::degreesBetween<float>(found, turn.inverse().matrix()), 0.1);
    EXPECT_EQ(found.row(2), Eigen::RowVector4f(0, 0, 1, 0));
    EXPECT_EQ(aligner.getResult().motions, Motions::Planar);
  };
  check(icp);
  IterativeClosestPointNonLinear<PointXYZ, PointXYZ> non_linear;
  check(non_linear);
  GeneralizedIterativeClosestPoint<PointXYZ, PointXYZ> generalized;
  check(generalized);
  Icp accelerated;
  accelerated.setAndersonAcceleration(true);
  check(accelerated);
}

TEST_F(LossAndMotions, FewerMotionsKeepTheRestOfTheGuess)
{
  Eigen::Matrix4d guess = Eigen::Matrix4d::Identity();
  guess.topLeftCorner<3, 3>() = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  guess.topRightCorner<3, 1>() << 100, -50, 7;
  source = scenes::moved(*source, Eigen::Affine3f(guess.inverse().cast<float>()));
  for (const Metric metric : metrics)
    for (const Motions motions : {Motions::Planar, Motions::Yaw, Motions::Translation}) {
      for (const bool accelerated : {false, true}) {
        SCOPED_TRACE(toString(metric) + std::string(", ") + toString(motions) + (accelerated ? ", Anderson" : ""));
        IterativeClosestPoint<PointXYZ, PointXYZ, double> aligner;
        aligner.setMetric(metric);
        aligner.setMotions(motions);
        aligner.setAndersonAcceleration(accelerated);
        aligner.setMaximumIterations(20);
        aligner.setInputSource(source);
        aligner.setInputTarget(target);
        Cloud output;
        aligner.align(output, guess);
        ASSERT_TRUE(aligner.hasConverged()) << aligner.getResult().message;
        const Eigen::Matrix4d done = aligner.getFinalTransformation() * guess.inverse();
        const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
        EXPECT_LT((done.topLeftCorner<3, 3>() * up - up).norm(), 1e-14);
        EXPECT_EQ(std::abs(done(0, 1)) > 1e-14, motions != Motions::Translation);
        EXPECT_EQ(std::abs(done(2, 3)) > 1e-12, motions != Motions::Planar);
      }
    }
}

TEST_F(LossAndMotions, FlatCloudsArePlanar)
{
  // A wall with a niche, as a 2-D lidar sees it.
  const auto outline = [](std::size_t n) {
    Cloud::Ptr cloud(new Cloud);
    for (std::size_t i = 0; i < n; ++i) {
      const float s = 8 * static_cast<float>(i) / static_cast<float>(n) - 4;
      cloud->push_back({s, std::abs(s) < 1 ? 3 + 0.5F * s : 2 - 0.1F * s * s, 0});
    }
    return cloud;
  };
  target = outline(2000);
  const Eigen::Affine3f turn(Eigen::Translation3f(0.03F, -0.02F, 0) *
                             Eigen::AngleAxisf(0.02F, Eigen::Vector3f::UnitZ()));
  source = scenes::moved(*outline(1500), turn);
  for (const Metric metric : {Metric::Point, Metric::Generalized}) {
    SCOPED_TRACE(toString(metric));
    Icp aligner;
    aligner.setMetric(metric);
    aligner.setMotions(Motions::Planar);
    aligner.setMaximumIterations(200);
    const Eigen::Matrix4f found = aligned(aligner);
    EXPECT_EQ(found.row(2), Eigen::RowVector4f(0, 0, 1, 0));
    EXPECT_LT(scenes::degreesBetween<float>(found, turn.inverse().matrix()), 0.1);
    EXPECT_LT(scenes::metresBetween<float>(found, turn.inverse().matrix()), 5e-3);
    EXPECT_EQ(aligner.getResult().degeneracy, Degeneracy::None);
  }
}

TEST_F(LossAndMotions, ExcludeWhatTheDeviceDoesNotEstimate)
{
  const auto refuses = [&](Icp& aligner, const std::string& what) {
    aligner.setInputSource(source);
    aligner.setInputTarget(target);
    Cloud output;
    aligner.align(output);
    EXPECT_FALSE(aligner.hasConverged());
    EXPECT_EQ(aligner.getResult().reason, Reason::Error);
    EXPECT_NE(aligner.getResult().message.find(what), std::string::npos) << aligner.getResult().message;
  };
  Icp with_search;
  with_search.setSearchMethodTarget(pcl::make_shared<pcl::search::KdTree<PointXYZ>>());
  with_search.setLoss({LossFunction::Huber, 0.1});
  refuses(with_search, "a loss excludes a search method");
  with_search.setLoss({});
  with_search.setMotions(Motions::Yaw);
  refuses(with_search, "fewer than six motions excludes a search method");
  Icp with_estimation;
  with_estimation.setTransformationEstimation(
      pcl::make_shared<pcl::registration::TransformationEstimationLM<PointXYZ, PointXYZ>>());
  with_estimation.setMotions(Motions::Yaw);
  refuses(with_estimation, "fewer than six motions excludes");
  Icp negative;
  negative.setLoss({LossFunction::Huber, -1});
  refuses(negative, "the scale of a loss");
}

} // namespace
} // namespace pcl_gpu_icp::test
