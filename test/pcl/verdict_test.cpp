// Whether judge() is to be believed: alignments whose answer is known, good ones and all ways to be wrong.
#include "judged_pair.h"
#include "scans.h"
#include "scenes.h"

#include <pcl_gpu_icp/batch.h>
#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/search/points_of.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace pcl_gpu_icp::test {
namespace {

using pcl::PointXYZ;
using scans::Cloud;
using Icp = IterativeClosestPoint<PointXYZ, PointXYZ, double>;

AlignmentResult aligned(const Cloud::Ptr& source,
                        const Cloud::Ptr& target,
                        const Eigen::Affine3d& guess = Eigen::Affine3d::Identity(),
                        Metric metric = Metric::Point)
{
  Icp icp;
  icp.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree);
  icp.setMaximumIterations(60);
  icp.setMetric(metric);
  icp.setInputSource(source);
  icp.setInputTarget(target);
  icp.alignWithoutOutput(guess.matrix());
  return icp.getResult();
}

/// Of the source where it is.
Quality qualityAsItLies(const Cloud& source, const Cloud& target, unsigned threads = 0)
{
  return qualityOf(search::pointsOf(source), search::pointsOf(target), {}, {}, threads);
}

Verdict verdictAsItLies(const Cloud& source, const Cloud& target)
{
  return judge(qualityAsItLies(source, target)).verdict;
}

Cloud::Ptr scaled(const Cloud& cloud, float by)
{
  const Cloud::Ptr result(new Cloud(cloud));
  for (PointXYZ& point : *result)
    point.getVector3fMap() *= by;
  return result;
}

Cloud::Ptr shifted(const Cloud& cloud, float x, float y, float z)
{
  return scenes::moved(cloud, Eigen::Affine3f(Eigen::Translation3f(x, y, z)));
}

TEST(VerdictOfMadePairs, IsRarelyGoodForWhatIsNotAndRarelyWrongForWhatIsRight)
{
  constexpr int repetitions = 1;
  constexpr unsigned seed = 3; // the limits were set on those of others
  int good = 0, good_and_off = 0, right = 0, right_and_good = 0, right_and_wrong = 0, off = 0, off_and_wrong = 0;
  for (const made_pairs::Pair& pair : made_pairs::makePairs(scans::folder, repetitions, seed))
    for (const Metric metric : {Metric::Point, Metric::Plane}) {
      SCOPED_TRACE(pair.kind + " " + pair.clouds + " " + toString(metric));
      const auto [result, judgement, spacings_off, is_right] = made_pairs::judged(pair, metric);
      EXPECT_EQ(judgement.reasons.empty(), judgement.verdict == Verdict::Good);
      good += judgement.verdict == Verdict::Good;
      (is_right ? right : off) += 1;
      if (is_right) {
        right_and_good += judgement.verdict == Verdict::Good;
        right_and_wrong += judgement.verdict == Verdict::Wrong;
      }
      else {
        good_and_off += judgement.verdict == Verdict::Good;
        off_and_wrong += judgement.verdict == Verdict::Wrong;
      }
      if (!pair.isRelated()) {
        EXPECT_NE(judgement.verdict, Verdict::Good);
      }
    }
  RecordProperty("right", right);
  RecordProperty("off", off);
  RecordProperty("good_and_off", good_and_off);
  ASSERT_GE(right, 20);
  ASSERT_GE(off, 4);
  EXPECT_LE(good_and_off, std::max(1, good / 100));
  EXPECT_LE(right_and_wrong, right / 20);
  EXPECT_GE(right_and_good, 2 * right / 3);
  EXPECT_GE(off_and_wrong, off / 2);
}

TEST(Verdict, IsGoodForAnAlignmentOfHillsAndWrongForOneOfUpsideDownHills)
{
  const Cloud::Ptr target = scenes::hills<PointXYZ>(3000, 1), source = scenes::hills<PointXYZ>(3000, 2);
  for (const Metric metric : {Metric::Point, Metric::Plane, Metric::Generalized}) {
    const Eigen::Affine3d away(Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()));
    const AlignmentResult result = aligned(source, target, away, metric);
    ASSERT_TRUE(result.quality);
    EXPECT_EQ(judge(*result.quality).verdict, Verdict::Good) << toString(metric);
    EXPECT_GT(result.quality->after.source, result.quality->before.source);
    EXPECT_GT(result.quality->after.target, result.quality->before.target);
  }
  const Eigen::Affine3d upright(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  const AlignmentResult result = aligned(source, target, upright);
  ASSERT_TRUE(result.quality);
  EXPECT_EQ(judge(*result.quality).verdict, Verdict::Wrong);
}

TEST(Verdict, TellsHowFarARightPoseIs)
{
  const Cloud::Ptr target = scenes::hills<PointXYZ>(8000, 1), source = scenes::hills<PointXYZ>(8000, 2);
  const double spacing = qualityAsItLies(*source, *target).spacing;
  EXPECT_NEAR(spacing, 4 / std::sqrt(8000.0), 0.2 * 4 / std::sqrt(8000.0)); // of 4 m by 4 m, a little more as it bends
  for (const double off : {0.0, 0.5, 1.0, 1.5, 2.0}) {
    const auto by = static_cast<float>(off * spacing);
    const Quality quality = qualityAsItLies(*shifted(*source, 0, 0, by), *target);
    ASSERT_TRUE(quality.surfaces);
    EXPECT_NEAR(quality.surfaces->pull, off, 0.25) << off;
  }
}

TEST(Verdict, IsNotGoodForASmallCloudOnOneFace)
{
  // A cube's shell shrunk onto a face of a large one: every source point is on the target, of whose part in view most
  // has no source point near it only where the source is on one face of many.
  std::mt19937 generator(4);
  std::uniform_real_distribution<float> place(-1, 1);
  const Cloud::Ptr target(new Cloud), source(new Cloud);
  for (int i = 0; i < 12000; ++i) {
    Eigen::Vector3f point(place(generator), place(generator), place(generator));
    point[i % 3] = i % 2 ? 1 : -1;
    target->emplace_back(point.x(), point.y(), point.z());
  }
  for (int i = 0; i < 1000; ++i)
    source->emplace_back(1, 0.4F * place(generator), 0.4F * place(generator));
  const Judgement judgement = judge(qualityAsItLies(*source, *target));
  EXPECT_EQ(judgement.verdict, Verdict::Doubtful);
  ASSERT_FALSE(judgement.reasons.empty());
  EXPECT_NE(judgement.reasons[0].find("motion along them"), std::string::npos) << judgement.reasons[0];
}

TEST(Verdict, IsDoubtfulWhereSurfacesSlide)
{
  // Planes and spheres leave motions free in whatever way they are matched.
  std::mt19937 generator(5);
  std::uniform_real_distribution<float> place(-1, 1);
  std::normal_distribution<float> normal;
  const auto plane = [&] {
    const Cloud::Ptr cloud(new Cloud);
    for (int i = 0; i < 3000; ++i)
      cloud->emplace_back(place(generator), place(generator), 0.003F * normal(generator));
    return cloud;
  };
  const auto sphere = [&] {
    const Cloud::Ptr cloud(new Cloud);
    for (int i = 0; i < 3000; ++i) {
      const Eigen::Vector3f at = Eigen::Vector3f(normal(generator), normal(generator), normal(generator)).normalized();
      cloud->emplace_back(at.x(), at.y(), at.z());
    }
    return cloud;
  };
  EXPECT_EQ(verdictAsItLies(*plane(), *plane()), Verdict::Doubtful);
  EXPECT_EQ(verdictAsItLies(*sphere(), *sphere()), Verdict::Doubtful);
}

/// What a scanner that turns in one plane sees of a room with a recess.
Cloud::Ptr flatRoom(double phase)
{
  const Cloud::Ptr cloud(new Cloud);
  for (int i = 0; i < 720; ++i) {
    const double angle = 2 * M_PI * (i + phase) / 720;
    double distance = std::min(3 / std::abs(std::cos(angle)), 2 / std::abs(std::sin(angle)));
    if (i % 180 < 50)
      distance *= 0.7;
    cloud->emplace_back(
        static_cast<float>(distance * std::cos(angle)), static_cast<float>(distance * std::sin(angle)), 0.0F);
  }
  return cloud;
}

TEST(Verdict, KnowsFlatScans)
{
  const Cloud::Ptr target = flatRoom(0), source = flatRoom(0.4);
  EXPECT_EQ(verdictAsItLies(*source, *target), Verdict::Good);
  EXPECT_NE(verdictAsItLies(*shifted(*source, 0.3F, 0.2F, 0), *target), Verdict::Good);
  // A floor without an outline to hold it.
  std::mt19937 generator(6);
  std::uniform_real_distribution<float> place(-1, 1);
  const Cloud::Ptr floor(new Cloud), another(new Cloud);
  for (const auto& cloud : {floor, another})
    for (int i = 0; i < 2000; ++i)
      cloud->emplace_back(place(generator), place(generator), 0.0F);
  EXPECT_EQ(verdictAsItLies(*floor, *another), Verdict::Doubtful);
}

TEST(Verdict, GoesByDistancesWhereThereAreNoSurfaces)
{
  std::mt19937 generator(7);
  std::uniform_real_distribution<float> place(0, 1);
  const Cloud::Ptr cloud(new Cloud);
  for (int i = 0; i < 2000; ++i)
    cloud->emplace_back(place(generator), place(generator), place(generator));
  const Quality quality = qualityAsItLies(*cloud, *cloud);
  EXPECT_FALSE(quality.surfaces);
  EXPECT_EQ(judge(quality).verdict, Verdict::Good);
  EXPECT_NE(verdictAsItLies(*shifted(*cloud, 0.2F, 0, 0), *cloud), Verdict::Good);
  // All of it fits between the points of the other cloud, anywhere.
  std::normal_distribution<float> normal(0.5F, 0.015F);
  Cloud speck;
  for (int i = 0; i < 2000; ++i)
    speck.emplace_back(normal(generator), normal(generator), normal(generator));
  EXPECT_NE(verdictAsItLies(speck, *cloud), Verdict::Good);
}

TEST(Verdict, IsTheSameInAnyUnitAndAnywhere)
{
  const Cloud::Ptr target = scenes::hills<PointXYZ>(3000, 1), source = scenes::hills<PointXYZ>(3000, 2);
  const Quality here = qualityAsItLies(*source, *target);
  for (const float scale : {1e-9F, 1e-4F, 1e5F, 1e9F}) {
    const Quality there = qualityAsItLies(*scaled(*source, scale), *scaled(*target, scale));
    EXPECT_NEAR(there.spacing / scale, here.spacing, 1e-4 * here.spacing) << scale;
    EXPECT_NEAR(there.after.source, here.after.source, 0.01);
    EXPECT_NEAR(there.median_distance, here.median_distance, 0.01);
    EXPECT_EQ(judge(there).verdict, Verdict::Good) << scale;
  }
  const Quality far = qualityAsItLies(*shifted(*source, 3000, 4000, 0), *shifted(*target, 3000, 4000, 0));
  EXPECT_NEAR(far.median_distance, here.median_distance, 0.02);
  EXPECT_EQ(judge(far).verdict, Verdict::Good);
}

TEST(Verdict, IsNotDecidedByPointsThatAreNotFiniteOrFarAway)
{
  const Cloud::Ptr target = scenes::hills<PointXYZ>(3000, 1), source = scenes::hills<PointXYZ>(3000, 2);
  const Quality without = qualityAsItLies(*source, *target);
  for (const auto& cloud : {source, target}) {
    cloud->emplace_back(NAN, 0, 0);
    cloud->emplace_back(1e10F, 0, 0);
    cloud->emplace_back(3e38F, 3e38F, 0);
  }
  const Quality with = qualityAsItLies(*source, *target);
  EXPECT_NEAR(with.spacing, without.spacing, 0.05 * without.spacing);
  EXPECT_NEAR(with.after.source, without.after.source, 0.01);
  EXPECT_NEAR(with.after.target, without.after.target, 0.02);
  EXPECT_EQ(judge(with).verdict, Verdict::Good);
}

TEST(Verdict, CountsPointsThatRepeatOthersOnce)
{
  const Cloud::Ptr target = scenes::hills<PointXYZ>(3000, 1), source = scenes::hills<PointXYZ>(3000, 2);
  const Quality without = qualityAsItLies(*source, *target);
  Cloud piled(*target), repeated;
  for (int i = 0; i < 8000; ++i)
    piled.emplace_back(0.0F, 0.0F, 0.0F);
  for (int i = 0; i < 4; ++i)
    repeated += *target;
  for (const Cloud& cloud : {piled, repeated}) {
    const Quality with = qualityAsItLies(*source, cloud);
    EXPECT_NEAR(with.spacing, without.spacing, 0.35 * without.spacing); // of a part of the points
    EXPECT_EQ(judge(with).verdict, Verdict::Good);
  }
}

TEST(Verdict, OfAWholeOntoAPartIsNotWrong)
{
  const Cloud::Ptr all = scenes::hills<PointXYZ>(8000, 2), others = scenes::hills<PointXYZ>(8000, 1), part(new Cloud);
  for (const PointXYZ& point : *others)
    if (point.x > -1 && point.x < 0.5F && point.y > -1 && point.y < 0.5F)
      part->push_back(point);
  const Quality quality = qualityAsItLies(*all, *part);
  EXPECT_LT(quality.after.source, 0.25);
  EXPECT_NE(judge(quality).verdict, Verdict::Wrong);
  EXPECT_EQ(verdictAsItLies(*part, *all), Verdict::Good);
}

TEST(Verdict, IsDoubtfulOfTooFewPoints)
{
  Cloud one, line, none;
  for (int i = 0; i < 50; ++i) {
    one.emplace_back(1, 2, 3);
    line.emplace_back(0.1F * static_cast<float>(i), 0, 0);
  }
  EXPECT_EQ(verdictAsItLies(one, one), Verdict::Doubtful);
  EXPECT_EQ(verdictAsItLies(none, one), Verdict::Doubtful);
  EXPECT_EQ(verdictAsItLies(one, none), Verdict::Doubtful);
  EXPECT_EQ(verdictAsItLies(line, line), Verdict::Doubtful);
}

TEST(Verdict, HasTheSameNumbersForAnyThreadsAndInABatch)
{
  const Cloud::Ptr target = scenes::hills<PointXYZ>(30000, 1), source = scenes::hills<PointXYZ>(30000, 2);
  const Eigen::Affine3d guess = scenes::smallMotion().cast<double>();
  const AlignmentResult alone = aligned(source, target, guess);
  ASSERT_TRUE(alone.quality && alone.quality->surfaces);
  const Quality one = qualityAsItLies(*source, *target, 1), three = qualityAsItLies(*source, *target, 3);
  ASSERT_TRUE(one.surfaces && three.surfaces);
  EXPECT_EQ(one.surfaces->pull, three.surfaces->pull);
  EXPECT_EQ(one.median_distance, three.median_distance);

  BatchAligner batch;
  for (int i = 0; i < 3; ++i)
    batch.add(60000, [&](DeviceLane& lane) {
      Icp icp;
      icp.setCorrespondenceSearch(CorrespondenceSearch::DeviceKdTree);
      icp.setMaximumIterations(60);
      icp.setInputSource(source);
      icp.setInputTarget(target);
      return BatchAligner::align(lane, icp, guess.matrix());
    });
  for (const BatchResult& result : batch.run()) {
    ASSERT_TRUE(result.alignment.quality && result.alignment.quality->surfaces);
    EXPECT_EQ(result.alignment.quality->surfaces->pull, alone.quality->surfaces->pull);
    EXPECT_EQ(result.alignment.quality->after.source, alone.quality->after.source);
  }
}

TEST(Verdict, IsLeftOutOnRequestAndWithoutAnAnswer)
{
  const Cloud::Ptr hills = scenes::hills<PointXYZ>(500);
  Icp icp;
  EXPECT_TRUE(icp.getMeasureQuality());
  icp.setMeasureQuality(false);
  icp.setInputSource(hills);
  icp.setInputTarget(hills);
  icp.alignWithoutOutput();
  EXPECT_FALSE(icp.getResult().quality);
  icp.setMeasureQuality(true);
  icp.alignWithoutOutput();
  EXPECT_TRUE(icp.getResult().quality);
  icp.setMaxCorrespondenceDistance(1e-9);
  icp.alignWithoutOutput(Eigen::Affine3d(Eigen::Translation3d(1, 2, 3)).matrix());
  EXPECT_FALSE(icp.getResult().converged);
  EXPECT_FALSE(icp.getResult().quality);
}

} // namespace
} // namespace pcl_gpu_icp::test
