// RigidEstimator: both pipelines against the reference, and what it does with its arguments.
#include "engine/estimator_internals.h"
#include "estimator_cases.h"

#include <pcl_gpu_icp/error.h>

#include <limits>

namespace pcl_gpu_icp::test {

using Eigen::Isometry3d;
using Eigen::Vector3d;

TEST(StageRequests, AreThoseOfTheFiveStages)
{
  const auto requests = stageRequests(6);
  ASSERT_EQ(requests.size(), 5U);
  using Counts = std::vector<std::size_t>;
  const std::pair<std::string, Counts> expected[] = {{"centroid", {6, 3, 2, 1}},
                                                     {"demean", {6}},
                                                     {"cross_covariance", {6, 3, 2, 1}},
                                                     {"svd", {27, 9, 1}},
                                                     {"rigid_transform", {27, 9, 3}}};
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(requests[i].stage, expected[i].first);
    EXPECT_EQ(requests[i].work_items, expected[i].second);
  }
}

using Estimator = WithEstimator;

TEST_P(Estimator, AgreesWithTheReferenceForEverySize)
{
  for (const std::size_t n : device().sizes()) {
    SCOPED_TRACE(n);
    Random random(7000 + n);
    const Cloud source = snapped(random.cloud(n, {8, 6, 3}, {1, -2, 3}));
    // Noise of a few centimetres: the least-squares answer, not only the perfect one.
    const Cloud target = snapped(moved(source, random.motion(2)) + random.cloud(n, {0.05, 0.05, 0.05}, {0, 0, 0}));
    const Estimate result = estimate(source, target);
    const Reference expected = referenceOf(source, target);
    EXPECT_EQ(result.pairs, n);
    expectRigid(result, isDouble() ? 1e-12 : 1e-6);
    if (n < 3)
      continue;
    EXPECT_EQ(result.degeneracy, Degeneracy::None);
    const double tolerance = 100 * device().epsilon() * (n == 3 ? 100 : 1);
    EXPECT_LE((matrixOf(result.transform.rotation) - expected.R).cwiseAbs().maxCoeff(), tolerance);
    EXPECT_LE((vectorOf(result.transform.translation) - expected.t).cwiseAbs().maxCoeff(), 10 * tolerance);
    const StageValues& stages = result.stages;
    const Vector3d p = vectorOf(stages.source_pivot) + vectorOf(stages.source_centroid);
    const Vector3d q = vectorOf(stages.target_pivot) + vectorOf(stages.target_centroid);
    EXPECT_LE((p - expected.source_centroid).norm(), 10 * tolerance);
    EXPECT_LE((q - expected.target_centroid).norm(), 10 * tolerance);
    EXPECT_LE((matrixOf(stages.H) - expected.H).norm(), tolerance * expected.H.norm());
    EXPECT_LE((vectorOf(stages.S) - expected.S).norm(), tolerance * expected.S.norm());
  }
}

TEST_P(Estimator, AgreesWithTheReferenceForAMillionPairs)
{
  const std::size_t n = device().affordable(1'000'000);
  Random random(8);
  const Cloud source = random.cloud(n, {50, 30, 5}, {10, -20, 3});
  const Isometry3d truth = random.motion(10);
  const Estimate result = estimate(source, moved(source, truth));
  EXPECT_LE(rmsDifference(isometryOf(result.transform), truth, source), 2e-5);
}

TEST_P(Estimator, WorksAtEveryScale)
{
  Random random(9);
  const Cloud unit = random.cloud(device().affordable(300));
  for (const double scale : {1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6}) {
    SCOPED_TRACE(scale);
    const Cloud source = unit * float(scale);
    Isometry3d truth = random.motion(2);
    truth.translation() *= scale;
    const Estimate result = estimate(source, moved(source, truth));
    EXPECT_EQ(result.degeneracy, Degeneracy::None);
    expectRigid(result, isDouble() ? 1e-12 : 1e-6);
    EXPECT_LE(rmsDifference(isometryOf(result.transform), truth, source), 3e-6 * scale);
  }
}

TEST_P(Estimator, LeavesNonFinitePairsOut)
{
  Random random(10);
  Cloud source = random.cloud(500);
  Cloud target = moved(source, random.motion(2));
  const Estimate clean = estimate(source.rightCols(400), target.rightCols(400));
  for (int i = 0; i < 100; ++i)
    (i % 2 ? source : target)(i % 3, i) =
        i % 5 ? std::numeric_limits<float>::quiet_NaN() : std::numeric_limits<float>::infinity();
  const Estimate result = estimate(source, target);
  EXPECT_EQ(result.pairs, 400U);
  expectRigid(result, 1e-6);
  EXPECT_LE(rmsDifference(isometryOf(result.transform), isometryOf(clean.transform), source.rightCols(400)), 1e-5);
}

TEST_P(Estimator, OfOnlyNonFinitePairsIsEmpty)
{
  const Cloud source = Cloud::Constant(3, 50, std::numeric_limits<float>::quiet_NaN());
  const Estimate result = estimate(source, source);
  EXPECT_EQ(result.degeneracy, Degeneracy::Empty);
  EXPECT_EQ(result.pairs, 0U);
  EXPECT_TRUE(isometryOf(result.transform).isApprox(Isometry3d::Identity(), 0));
}

TEST_P(Estimator, RefusesCountsThatDiffer)
{
  Random random(11);
  const Cloud source = random.cloud(5), target = random.cloud(4);
  estimator_.takeTimes();
  try {
    estimate(source, target);
    FAIL() << "nothing was thrown";
  } catch (const InvalidArgument& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find('5'), std::string::npos) << what;
    EXPECT_NE(what.find('4'), std::string::npos) << what;
  }
  EXPECT_TRUE(estimator_.takeTimes().empty()) << "nothing was enqueued";
}

// Rows are indexed with 32 bits on the device.
TEST_P(Estimator, RefusesCloudsThatItCannotIndex)
{
  const float point[3] = {1, 2, 3};
  const Points endless{point, std::size_t(1) << 31, 0, nullptr, 0};
  estimator_.takeTimes();
  EXPECT_THROW(estimator_.estimate(endless, endless), InvalidArgument);
  EXPECT_THROW(estimator_.setSource(endless), InvalidArgument);
  EXPECT_THROW(estimator_.setTarget(endless), InvalidArgument);
  const Points too_many{point, 600'000'000, 0, nullptr, 0};
  EXPECT_THROW(estimator_.estimate(too_many, too_many), InvalidArgument);
  EXPECT_TRUE(estimator_.takeTimes().empty()) << "nothing was enqueued";
}

TEST_P(Estimator, RefusesWhatTheDeviceCannotHold)
{
  opencl::Traits traits = device().traits;
  traits.max_allocation = 4000;
  RigidEstimator limited = makeEstimator(device().device, traits, GetParam().pipeline, device().precision);
  Random random(12);
  const Cloud small = random.cloud(10), large = random.cloud(1000);
  EXPECT_THROW(limited.estimate(viewOf(large), viewOf(large)), DeviceError);
  EXPECT_EQ(limited.estimate(viewOf(small), viewOf(small)).pairs, 10U) << "and works on what it can hold";
  limited.setSource(viewOf(small));
  EXPECT_THROW(limited.setSource(viewOf(large)), DeviceError);
  limited.setTarget(viewOf(small));
  const Correspondence beyond{500, 0, 0};
  EXPECT_THROW(limited.estimate(&beyond, 1, {}), InvalidArgument) << "the large cloud is not there";
}

// The same arithmetic on the same numbers, whatever the way they came.
TEST_P(Estimator, OfResidentCloudsIsTheEstimateOfTheMovedPairs)
{
  Random random(13);
  const Cloud source = random.cloud(700), target = random.cloud(900);
  std::vector<Correspondence> matches(device().affordable(600));
  Cloud p(3, matches.size()), q(3, matches.size());
  const Isometry3d pose = random.motion(3);
  for (std::size_t k = 0; k < matches.size(); ++k) {
    matches[k] = {std::int32_t(random.count(0, 699)), std::int32_t(random.count(0, 899)), 0};
    p.col(k) = (pose * Vector3d(source.col(matches[k].source).cast<double>())).cast<float>();
    q.col(k) = target.col(matches[k].target);
  }
  estimator_.setSource(viewOf(source));
  estimator_.setTarget(viewOf(target));
  for (int run = 0; run < 2; ++run) {
    const Estimate resident = estimator_.estimate(matches.data(), matches.size(), transformOf(pose));
    EXPECT_EQ(resident.pairs, matches.size());
    EXPECT_EQ(resident.degeneracy, Degeneracy::None);
    expectRigid(resident, 1e-6);
    const Estimate expected = estimate(p, q);
    // Random matches leave small singular values, on which R depends most.
    EXPECT_LE(rmsDifference(isometryOf(resident.transform), isometryOf(expected.transform), p), 1e-3);
    EXPECT_NEAR(
        rmsResidual(isometryOf(resident.transform), p, q), rmsResidual(isometryOf(expected.transform), p, q), 1e-5);
  }
}

TEST_P(Estimator, OfResidentCloudsRecoversWhatThePoseLacks)
{
  Random random(14);
  for (const double offset : {0.0, 1e3, 5e5}) {
    SCOPED_TRACE(offset);
    const Cloud source = random.cloud(device().affordable(1000), {20, 20, 3}, {offset, -offset, 5});
    const Isometry3d truth = motion({0.1, 0.2, 1}, 0.3, {1, 2, 3});
    const Cloud target = moved(source, truth);
    const Vector3d centre(offset, -offset, 5);
    Isometry3d increment = motion({1, 1, 0}, 0.05, {0.2, 0.1, -0.1});
    increment.translation() += truth * centre - increment.linear() * (truth * centre);
    const Isometry3d pose = increment.inverse() * truth;
    std::vector<Correspondence> matches;
    for (int i = 0; i < source.cols(); i += 2)
      matches.push_back({i, i, 0});
    estimator_.setSource(viewOf(source));
    estimator_.setTarget(viewOf(target));
    const Estimate result = estimator_.estimate(matches.data(), matches.size(), transformOf(pose));
    // The input's own rounding: half a float32 step of the coordinates.
    EXPECT_LE(rmsDifference(isometryOf(result.transform) * pose, truth, source), 2e-5 + 6e-8 * offset);
  }
}

TEST_P(Estimator, RefusesCorrespondencesOfPointsThatAreNotThere)
{
  Random random(15);
  const Cloud source = random.cloud(10), target = random.cloud(20);
  estimator_.setSource(viewOf(source));
  estimator_.setTarget(viewOf(target));
  estimator_.takeTimes();
  for (const Correspondence& stray : {Correspondence{10, 0, 0},
                                      Correspondence{0, 20, 0},
                                      Correspondence{-1, 0, 0},
                                      Correspondence{0, -1, 0},
                                      Correspondence{0, std::numeric_limits<std::int32_t>::max(), 0}}) {
    const Correspondence matches[3] = {{0, 0, 0}, {9, 19, 0}, stray};
    EXPECT_THROW(estimator_.estimate(matches, 3, {}), InvalidArgument);
  }
  EXPECT_TRUE(estimator_.takeTimes().empty()) << "nothing was enqueued";
  const Correspondence last{9, 19, 0};
  EXPECT_EQ(estimator_.estimate(&last, 1, {}).pairs, 1U);
}

TEST_P(Estimator, RefusesCorrespondencesOfPointsThatAreNotFinite)
{
  Random random(20);
  Cloud source = random.cloud(100);
  const Cloud target = random.cloud(100);
  source(1, 50) = std::numeric_limits<float>::quiet_NaN();
  estimator_.setSource(viewOf(source));
  estimator_.setTarget(viewOf(target));
  std::vector<Correspondence> matches;
  for (int i = 0; i < 100; ++i)
    matches.push_back({i, i, 0});
  EXPECT_THROW(estimator_.estimate(matches.data(), matches.size(), {}), InvalidArgument);
  matches.erase(matches.begin() + 50);
  EXPECT_NO_THROW(estimator_.estimate(matches.data(), matches.size(), {}));
}

TEST_P(Estimator, OfNoCorrespondencesIsEmpty)
{
  Random random(16);
  const Cloud cloud = random.cloud(10);
  estimator_.setSource(viewOf(cloud));
  estimator_.setTarget(viewOf(cloud));
  const Estimate result = estimator_.estimate(nullptr, 0, {});
  EXPECT_EQ(result.degeneracy, Degeneracy::Empty);
  EXPECT_TRUE(isometryOf(result.transform).isApprox(Isometry3d::Identity(), 0));
}

TEST_P(Estimator, TakesEmptyClouds)
{
  EXPECT_NO_THROW(estimator_.setSource({}));
  EXPECT_NO_THROW(estimator_.setTarget({}));
  const Correspondence match{0, 0, 0};
  EXPECT_THROW(estimator_.estimate(&match, 1, {}), InvalidArgument);
  EXPECT_EQ(estimator_.estimate(Points{}, Points{}).degeneracy, Degeneracy::Empty);
}

TEST_P(Estimator, ShowsTheDemeanedPointsOfTheStagedPipelineOnly)
{
  Random random(17);
  const Cloud source = random.cloud(100), target = random.cloud(100);
  estimate(source, target);
  if (GetParam().pipeline == Pipeline::Fused) {
    EXPECT_THROW(estimator_.demeaned(), InvalidArgument);
    return;
  }
  const auto rows = estimator_.demeaned();
  ASSERT_EQ(rows.size(), 600U);
  const Reference expected = referenceOf(source, target);
  for (int i = 0; i < 100; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(rows[axis * 100 + i], expected.source_demeaned(axis, i), 1e-5);
      EXPECT_NEAR(rows[(3 + axis) * 100 + i], expected.target_demeaned(axis, i), 1e-5);
    }
}

TEST_P(Estimator, AccountsForEveryStageAndTransfer)
{
  if (device().inPasses())
    GTEST_SKIP() << "each pass is a command";
  Random random(18);
  const Cloud cloud = random.cloud(100);
  estimator_.takeTimes();
  estimate(cloud, cloud);
  estimate(cloud, cloud);
  const StageTimes times = estimator_.takeTimes();
  std::map<std::string, unsigned> expected = {{"upload", 2}, {"download", 2}};
  if (GetParam().pipeline == Pipeline::Fused)
    expected.insert({{"listed_sums", 2}, {"listed_solve", 2}});
  else {
    const unsigned reductions = stageRequests(100)[0].work_items.size() + 1;
    expected.insert({{"centroid", 2 * reductions},
                     {"demean", 2},
                     {"cross_covariance", 2 * reductions},
                     {"svd", 2},
                     {"rigid_transform", 2}});
  }
  ASSERT_EQ(times.size(), expected.size());
  for (const auto& [what, count] : expected) {
    ASSERT_TRUE(times.count(what)) << what;
    EXPECT_EQ(times.at(what).count, count) << what;
    EXPECT_GE(times.at(what).milliseconds, 0) << what;
  }
  EXPECT_TRUE(estimator_.takeTimes().empty());
}

TEST_P(Estimator, StartsWithNoTimesOfItsOwn) { EXPECT_TRUE(estimator_.takeTimes().empty()); }

TEST_P(Estimator, TellsWhatItRunsOn)
{
  EXPECT_EQ(estimator_.pipeline(), GetParam().pipeline);
  EXPECT_EQ(estimator_.precision(), device().precision);
  EXPECT_EQ(estimator_.device().name, device().device.info().name);
}

TEST_P(Estimator, CanBeMoved)
{
  Random random(19);
  const Cloud cloud = random.cloud(50);
  const Estimate before = estimate(cloud, cloud);
  RigidEstimator other = std::move(estimator_);
  EXPECT_TRUE(identical(other.estimate(viewOf(cloud), viewOf(cloud)), before));
  estimator_ = std::move(other);
  EXPECT_TRUE(identical(estimate(cloud, cloud), before));
}

RUN_EVERY_ESTIMATOR(Estimator);

TEST(EstimatorPrecision, IsFloatAndSaysSoWhereTheDeviceHasNoDouble)
{
  for (const DeviceCase& device : memoryCases()) {
    opencl::Traits traits = device.traits;
    traits.fp64 = false;
    EXPECT_EQ(makeEstimator(device.device, traits, Pipeline::Fused, Precision::Double).precision(), Precision::Float);
  }
}

} // namespace pcl_gpu_icp::test
