// BatchAligner: every pair's answer is, to the bit, the one it gets alone.
#include "scenes.h"

#include "../rooms/watchdog.h"

#include <pcl_gpu_icp/batch.h>
#include <pcl_gpu_icp/gicp.h>
#include <pcl_gpu_icp/transformation_estimation_point_to_plane_lls.h>

#include <pcl/registration/correspondence_rejection_distance.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>

namespace pcl_gpu_icp::test {

namespace {

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;
using Icp = IterativeClosestPoint<Point, Point>;

struct Pair {
  Cloud::Ptr source, target;
};

std::vector<Pair> pairsOf(std::size_t count)
{
  std::vector<Pair> pairs;
  for (unsigned i = 0; i < count; ++i) {
    const auto target = scenes::hills<Point>(300 + 700 * (i % 5), i);
    pairs.push_back(
        {scenes::moved(*scenes::hills<Point>(200 + 500 * (i % 7), 100 + i), scenes::smallMotion()), target});
  }
  return pairs;
}

struct Alone {
  AlignmentResult result;
  RigidTransform transform;
  double fitness;
};

Alone alignAlone(const Pair& pair, const std::function<void(Icp&)>& configure)
{
  Icp icp;
  configure(icp);
  icp.setInputSource(pair.source);
  icp.setInputTarget(pair.target);
  Cloud output;
  icp.align(output);
  return {icp.getResult(), detail::toRigidTransform<float>(icp.getFinalTransformation()), icp.getFitnessScore()};
}

void expectSame(const BatchResult& result, const Alone& alone)
{
  EXPECT_EQ(result.transform.rotation, alone.transform.rotation);
  EXPECT_EQ(result.transform.translation, alone.transform.translation);
  EXPECT_EQ(result.alignment.reason, alone.result.reason) << result.alignment.message;
  EXPECT_EQ(result.alignment.converged, alone.result.converged);
  EXPECT_EQ(result.alignment.iterations, alone.result.iterations);
  EXPECT_EQ(result.alignment.searched, alone.result.searched);
  EXPECT_EQ(result.alignment.inliers, alone.result.inliers);
  EXPECT_EQ(result.alignment.rmse, alone.result.rmse);
  EXPECT_EQ(result.alignment.rmse_before, alone.result.rmse_before);
  EXPECT_EQ(result.alignment.degeneracy, alone.result.degeneracy);
}

} // namespace

struct BatchCase {
  CorrespondenceSearch search;
  Pipeline pipeline;
  std::size_t capacity;
};

class Batch : public testing::TestWithParam<BatchCase> {
protected:
  std::function<void(Icp&)> configure() const
  {
    const BatchCase c = GetParam();
    return [c](Icp& icp) {
      icp.setCorrespondenceSearch(c.search);
      icp.setPipeline(c.pipeline);
      icp.setMaximumIterations(15);
    };
  }
  BatchSettings settings() const
  {
    BatchSettings settings;
    settings.lanes = 4;
    settings.capacity = GetParam().capacity;
    return settings;
  }
  Watchdog watchdog_;
};

TEST_P(Batch, EveryPairGetsTheAnswerItGetsAlone)
{
  auto pairs = pairsOf(20);
  BatchAligner batch;
  batch.setSettings(settings());
  for (int run = 0; run < 2; ++run) {
    for (const Pair& pair : pairs)
      batch.add<Point, Point>(pair.source, pair.target, configure());
    const auto results = batch.run();
    ASSERT_EQ(results.size(), pairs.size());
    for (std::size_t i = 0; i < results.size(); ++i) {
      SCOPED_TRACE("pair " + std::to_string(i));
      expectSame(results[i], alignAlone(pairs[i], configure()));
    }
    std::reverse(pairs.begin(), pairs.end());
  }
}

TEST_P(Batch, ABadPairHarmsNoOther)
{
  auto pairs = pairsOf(9);
  pairs[1].source = pcl::make_shared<Cloud>();                      // empty
  pairs[3].target = pcl::make_shared<Cloud>();                      // empty
  pairs[5].source = pcl::make_shared<Cloud>(50, 1, Point(1, 2, 3)); // all in one place
  pairs[7].source =
      pcl::make_shared<Cloud>(50, 1, Point(std::numeric_limits<float>::quiet_NaN(), 0, 0)); // nothing finite
  BatchAligner batch;
  batch.setSettings(settings());
  for (const Pair& pair : pairs)
    batch.add<Point, Point>(pair.source, pair.target, configure());
  const auto results = batch.run();
  for (std::size_t i = 0; i < results.size(); ++i) {
    SCOPED_TRACE("pair " + std::to_string(i));
    expectSame(results[i], alignAlone(pairs[i], configure()));
    for (const double entry : results[i].transform.rotation)
      EXPECT_TRUE(std::isfinite(entry));
  }
  for (const std::size_t bad : {1, 3, 7})
    EXPECT_FALSE(results[bad].alignment.converged);
  EXPECT_EQ(results[5].alignment.degeneracy, Degeneracy::Point);
}

TEST_P(Batch, SourcesOfOneTargetShareItsTree)
{
  const auto target = scenes::hills<Point>(3000, 7);
  std::vector<Pair> pairs;
  for (unsigned i = 0; i < 12; ++i)
    pairs.push_back({scenes::moved(*scenes::hills<Point>(400, 50 + i), scenes::smallMotion()), target});
  BatchAligner batch;
  batch.setSettings(settings());
  for (const Pair& pair : pairs)
    batch.add<Point, Point>(pair.source, pair.target, configure());
  const auto results = batch.run();
  for (std::size_t i = 0; i < results.size(); ++i)
    expectSame(results[i], alignAlone(pairs[i], configure()));
}

INSTANTIATE_TEST_SUITE_P(,
                         Batch,
                         testing::Values(BatchCase{CorrespondenceSearch::DeviceKdTree, Pipeline::Fused, 0},
                                         BatchCase{CorrespondenceSearch::DeviceKdTree, Pipeline::Fused, 5},
                                         BatchCase{CorrespondenceSearch::PclKdTree, Pipeline::Fused, 0},
                                         BatchCase{CorrespondenceSearch::PclKdTree, Pipeline::Fused, 5},
                                         BatchCase{CorrespondenceSearch::DeviceKdTree, Pipeline::Staged, 20},
                                         BatchCase{CorrespondenceSearch::PclKdTree, Pipeline::Staged, 0}),
                         [](const auto& info) {
                           const BatchCase& c = info.param;
                           return std::string(c.search == CorrespondenceSearch::PclKdTree ? "HostTree" : "DeviceTree") +
                                  (c.pipeline == Pipeline::Staged ? "_Staged_" : "_Fused_") +
                                  std::to_string(c.capacity);
                         });

TEST(BatchAligner, OneTreeForAllLanesOfADevice)
{
  const auto target = scenes::hills<Point>(20'000, 3);
  BatchAligner batch;
  BatchSettings settings;
  settings.lanes = 3;
  batch.setSettings(settings);
  for (unsigned i = 0; i < 9; ++i)
    batch.add<Point, Point>(scenes::hills<Point>(300, i), target, [](Icp& icp) {
      icp.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree);
      icp.setMaximumIterations(3);
    });
  std::map<const MatchTarget*, int> targets;
  std::mutex mutex;
  for (unsigned i = 0; i < 9; ++i)
    batch.add(20'300, [&, i](DeviceLane& lane) {
      Icp icp;
      icp.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree);
      icp.setInputSource(scenes::hills<Point>(300, 20 + i));
      icp.setInputTarget(target);
      const BatchResult result = BatchAligner::align(lane, icp);
      const auto held = lane.targets->trees.get(lane.matcher_target, []() -> std::shared_ptr<const MatchTarget> {
        ADD_FAILURE() << "the lane's matcher holds it";
        return nullptr;
      });
      const std::lock_guard<std::mutex> lock(mutex);
      ++targets[held.get()];
      return result;
    });
  batch.run();
  EXPECT_EQ(targets.size(), 1U);
}

TEST(BatchAligner, NormalsOfASharedTargetAreEstimatedOnceAndScheduled)
{
  const auto target = scenes::hills<Point>(1000, 3);
  std::vector<Pair> pairs;
  for (unsigned i = 0; i < 9; ++i)
    pairs.push_back({scenes::moved(*scenes::hills<Point>(300, 20 + i), scenes::smallMotion()), target});
  for (const Metric metric : {Metric::Plane, Metric::Symmetric, Metric::Generalized}) {
    SCOPED_TRACE(toString(metric));
    const auto configure = [metric](Icp& icp) {
      icp.setMetric(metric);
      icp.setMaximumIterations(5);
    };
    BatchAligner batch;
    BatchSettings settings;
    settings.lanes = 3;
    settings.schedule = std::make_shared<Schedule>();
    batch.setSettings(settings);
    for (const Pair& pair : pairs)
      batch.add<Point, Point>(pair.source, pair.target, configure);
    const auto results = batch.run();
    for (std::size_t i = 0; i < results.size(); ++i)
      expectSame(results[i], alignAlone(pairs[i], configure));
    const auto spans = settings.schedule->spans();
    const auto estimated =
        std::count_if(spans.begin(), spans.end(), [](const auto& span) { return span.what == "normals"; });
    EXPECT_EQ(estimated, metric == Metric::Plane ? 1 : 10) << "GICP's are of the nine sources as well";
  }
}

TEST(BatchAligner, MixedSettingsOnTheSameLanes)
{
  const auto pairs = pairsOf(24);
  const std::vector<std::function<void(Icp&)>> configurations = {
      [](Icp&) {},
      [](Icp& icp) { icp.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree); },
      [](Icp& icp) { icp.setPipeline(Pipeline::Staged); },
      [](Icp& icp) { icp.setUseReciprocalCorrespondences(true); },
      [](Icp& icp) { icp.setAndersonAcceleration(true); },
      [](Icp& icp) {
        const auto rejector = pcl::make_shared<pcl::registration::CorrespondenceRejectorDistance>();
        rejector->setMaximumDistance(0.1F);
        icp.addCorrespondenceRejector(rejector);
      }};
  BatchAligner batch;
  BatchSettings settings;
  settings.lanes = 2;
  batch.setSettings(settings);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    batch.add<Point, Point>(pairs[i].source, pairs[i].target, configurations[i % configurations.size()]);
  const auto results = batch.run();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    SCOPED_TRACE("pair " + std::to_string(i));
    expectSame(results[i], alignAlone(pairs[i], configurations[i % configurations.size()]));
  }
}

TEST(BatchAligner, OtherClassesGetTheAnswersTheyGetAlone)
{
  using Generalized = GeneralizedIterativeClosestPoint<Point, Point>;
  const auto pairs = pairsOf(4);
  BatchAligner batch;
  for (const Pair& pair : pairs)
    batch.add(1000, [&pair](DeviceLane& lane) {
      Generalized icp;
      icp.setInputSource(pair.source);
      icp.setInputTarget(pair.target);
      return BatchAligner::align(lane, icp);
    });
  const auto results = batch.run();
  ASSERT_EQ(results.size(), pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    Generalized icp;
    icp.setInputSource(pairs[i].source);
    icp.setInputTarget(pairs[i].target);
    Cloud output;
    icp.align(output);
    EXPECT_TRUE(icp.hasConverged());
    EXPECT_EQ(toMatrix(results[i].transform), icp.getFinalTransformation());
    EXPECT_EQ(results[i].alignment.iterations, icp.getResult().iterations);
    EXPECT_EQ(results[i].alignment.metric, Metric::Generalized);
  }
}

TEST(BatchAligner, GuessScalarAndFitnessScore)
{
  const Pair pair = pairsOf(1).front();
  using IcpDouble = IterativeClosestPoint<Point, Point, double>;
  Eigen::Matrix4d guess = Eigen::Matrix4d::Identity();
  guess(0, 3) = 0.01;
  IcpDouble icp;
  icp.setInputSource(pair.source);
  icp.setInputTarget(pair.target);
  Cloud output;
  icp.align(output, guess);

  BatchAligner batch;
  batch.add<Point, Point, double>(
      pair.source, pair.target, [](IcpDouble&) {}, guess);
  batch.add(1, [&](DeviceLane& lane) {
    IcpDouble other;
    other.setInputSource(pair.source);
    other.setInputTarget(pair.target);
    return BatchAligner::align(lane, other, guess, true);
  });
  const auto results = batch.run();
  for (const BatchResult& result : results)
    EXPECT_EQ(result.transform.translation, detail::toRigidTransform<double>(icp.getFinalTransformation()).translation);
  EXPECT_FALSE(results[0].fitness_score);
  ASSERT_TRUE(results[1].fitness_score);
  EXPECT_EQ(*results[1].fitness_score, icp.getFitnessScore());
}

TEST(BatchAligner, AGuessThatIsNoneIsAnErrorAsItIsAlone)
{
  const Pair pair = pairsOf(1).front();
  Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
  guess(3, 0) = 0.5F;
  IterativeClosestPoint<Point, Point> icp;
  icp.setInputSource(pair.source);
  icp.setInputTarget(pair.target);
  Cloud output;
  icp.align(output, guess);
  ASSERT_EQ(icp.getResult().reason, Reason::Error);

  BatchAligner batch;
  batch.add<Point, Point>(pair.source, pair.target, {}, guess);
  const BatchResult result = batch.run().front();
  EXPECT_EQ(result.alignment.reason, Reason::Error);
  EXPECT_EQ(result.alignment.message, icp.getResult().message);
}

TEST(BatchAligner, CancelEndsAnAlignmentAtItsNextOperation)
{
  const Watchdog watchdog;
  const Pair pair = pairsOf(1).front();
  BatchAligner batch;
  int iterations = 0;
  batch.add<Point, Point>(pair.source, pair.target, [&](Icp& icp) {
    icp.setMaximumIterations(1'000'000);
    icp.setTransformationEpsilon(-1);
    icp.setEuclideanFitnessEpsilon(-1);
    static_cast<pcl::registration::DefaultConvergenceCriteria<float>&>(*icp.getConvergeCriteria()).setAbsoluteMSE(-1);
    icp.setIterationCallback([&](int iteration, double, std::size_t) {
      iterations = iteration;
      if (iteration == 5)
        batch.cancel(0);
    });
  });
  const auto results = batch.run();
  EXPECT_EQ(results[0].alignment.reason, Reason::Cancelled);
  EXPECT_FALSE(results[0].alignment.converged);
  EXPECT_EQ(iterations, 5);
}

TEST(BatchAligner, TheScheduleTellsWhatRanWhere)
{
  const auto pairs = pairsOf(10);
  BatchAligner batch;
  BatchSettings settings;
  settings.lanes = 3;
  settings.capacity = 9;
  settings.schedule = std::make_shared<Schedule>();
  batch.setSettings(settings);
  for (const Pair& pair : pairs)
    batch.add<Point, Point>(pair.source, pair.target, [](Icp& icp) {
      icp.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree);
      icp.setPipeline(Pipeline::Staged);
      icp.setMaximumIterations(4);
    });
  batch.run();

  std::map<std::size_t, std::vector<Schedule::Span>> lanes, of_pair;
  for (const Schedule::Span& span : settings.schedule->spans()) {
    EXPECT_LE(span.begin_ms, span.end_ms);
    if (span.what == "pair")
      continue;
    lanes[span.lane].push_back(span);
    of_pair[span.pair].push_back(span);
    EXPECT_LE(span.work_items, 9U);
  }
  EXPECT_LE(lanes.size(), 3U);
  for (const auto& [lane, spans] : lanes)
    for (std::size_t i = 1; i < spans.size(); ++i)
      EXPECT_GE(spans[i].begin_ms, spans[i - 1].end_ms) << "one operation of a lane after another";
  ASSERT_EQ(of_pair.size(), pairs.size());
  // The five operations of the source document, in its order, a few times.
  for (const auto& [pair, spans] : of_pair) {
    std::vector<std::string> order;
    for (const Schedule::Span& span : spans)
      if (span.what != "match" && span.what != "match_solve" && span.what != "gather" && span.what != "accumulate" &&
          (order.empty() || order.back() != span.what))
        order.push_back(span.what);
    ASSERT_EQ(order.size() % 5, 0U);
    const char* stages[] = {"centroid", "demean", "cross_covariance", "svd", "rigid_transform"};
    for (std::size_t i = 0; i < order.size(); ++i)
      ASSERT_EQ(order[i], stages[i % 5]);
  }
  for (const Schedule::Level& level : settings.schedule->levels())
    EXPECT_LE(level.idle, 9U);
  EXPECT_EQ(settings.schedule->levels().back().idle, 9U);
}

TEST(BatchAligner, SeveralDevices)
{
  const auto parts = Device::select("cpu").partition(1);
  ASSERT_GE(parts.size(), 2U);
  const auto pairs = pairsOf(12);
  BatchAligner batch({parts[0], parts[1]});
  for (const Pair& pair : pairs)
    batch.add<Point, Point>(pair.source, pair.target, [](Icp& icp) { icp.setMaximumIterations(5); });
  const auto results = batch.run();
  for (std::size_t i = 0; i < pairs.size(); ++i)
    expectSame(results[i], alignAlone(pairs[i], [](Icp& icp) { icp.setMaximumIterations(5); }));
}

TEST(BatchAligner, TransformsAreHandedToEigen)
{
  const auto pairs = pairsOf(1);
  BatchAligner batch;
  batch.add<Point, Point>(pairs[0].source, pairs[0].target);
  const auto results = batch.run();
  Icp icp;
  icp.setInputSource(pairs[0].source);
  icp.setInputTarget(pairs[0].target);
  icp.alignWithoutOutput();
  const Eigen::Matrix4f matrix = toMatrix(results[0].transform);
  EXPECT_EQ(matrix, icp.getFinalTransformation());
  EXPECT_EQ(toMatrix<double>(results[0].transform), matrix.cast<double>());
}

TEST(BatchAligner, AnAlignerThatLeftALaneIsWhatItWasBefore)
{
  const auto pairs = pairsOf(1);
  const auto parts = Device::select("cpu").partition(1);
  DeviceLane lane(parts[0], nullptr, std::make_shared<TargetCache>());
  for (const unsigned threads : {0U, 3U}) {
    const auto configure = [&](Icp& icp) {
      icp.setDevice(Device::select("cpu"));
      icp.setNumberOfThreads(threads);
      icp.setInputSource(pairs[0].source);
      icp.setInputTarget(pairs[0].target);
    };
    Icp fresh, returned;
    configure(fresh);
    configure(returned);
    fresh.alignWithoutOutput();
    BatchAligner::align(lane, returned);
    EXPECT_EQ(returned.getResult().threads, threads > 0 ? threads : lane.threads);
    EXPECT_EQ(returned.getResult().device.compute_units, 1U);
    EXPECT_EQ(returned.getNumberOfThreads(), fresh.getNumberOfThreads());
    Cloud output;
    returned.align(output);
    EXPECT_EQ(returned.getFinalTransformation(), fresh.getFinalTransformation());
    EXPECT_EQ(returned.getResult().threads, fresh.getResult().threads);
    EXPECT_EQ(returned.getResult().device.compute_units, fresh.getResult().device.compute_units);
    EXPECT_EQ(output.size(), pairs[0].source->size());
  }
}

TEST(BatchAligner, ACallbackThatThrowsInAnAlignmentWithoutOutputTakesNoOutputFromTheNext)
{
  const auto pairs = pairsOf(1);
  Icp icp;
  icp.setInputSource(pairs[0].source);
  icp.setInputTarget(pairs[0].target);
  icp.setIterationCallback([](int, double, std::size_t) { throw 1; });
  EXPECT_THROW(icp.alignWithoutOutput(), int);
  icp.setIterationCallback(nullptr);
  Cloud output;
  icp.align(output);
  EXPECT_EQ(output.size(), pairs[0].source->size());
}

TEST(BatchAligner, MissingCloudsAreRefused)
{
  BatchAligner batch;
  EXPECT_THROW((batch.add<Point, Point>(nullptr, scenes::hills<Point>(3))), InvalidArgument);
  EXPECT_THROW((batch.add<Point, Point>(scenes::hills<Point>(3), nullptr)), InvalidArgument);
}

} // namespace pcl_gpu_icp::test
