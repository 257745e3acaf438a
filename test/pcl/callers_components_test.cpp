// A caller's own estimator, correspondence estimation and rejectors see, to the bit, what they see in
// pcl::IterativeClosestPoint, and so lead to the same answer: every combination of PCL's, in double.
#include "callers_components.h"
#include "scans.h"
#include "scenes.h"

#include <pcl_gpu_icp/icp.h>

#include <pcl/features/normal_3d.h>
#include <pcl/filters/filter.h>
#include <pcl/registration/icp.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

using components::Estimator;
using components::Point;
using Cloud = pcl::PointCloud<Point>;
using Stock = pcl::IterativeClosestPoint<Point, Point, double>;
using Ours = pcl_gpu_icp::IterativeClosestPoint<Point, Point, double>;

namespace {

/// What an estimator was handed in one iteration.
struct Handed {
  pcl::Correspondences correspondences;
  std::vector<std::array<float, 3>> source;
};

/// Hands on to an estimator what it is handed, and keeps it.
class Spy : public Estimator {
public:
  explicit Spy(Estimator::Ptr estimator)
  : estimator_(std::move(estimator))
  {
  }

  void estimateRigidTransformation(const Cloud& source,
                                   const Cloud& target,
                                   const pcl::Correspondences& correspondences,
                                   Matrix4& matrix) const override
  {
    Handed now{correspondences, {}};
    for (const Point& point : source)
      now.source.push_back({point.x, point.y, point.z});
    handed.push_back(std::move(now));
    estimator_->estimateRigidTransformation(source, target, correspondences, matrix);
  }
  // ICP calls none of these.
  void estimateRigidTransformation(const Cloud&, const Cloud&, Matrix4&) const override { std::abort(); }
  void estimateRigidTransformation(const Cloud&, const pcl::Indices&, const Cloud&, Matrix4&) const override
  {
    std::abort();
  }
  void estimateRigidTransformation(
      const Cloud&, const pcl::Indices&, const Cloud&, const pcl::Indices&, Matrix4&) const override
  {
    std::abort();
  }

  mutable std::vector<Handed> handed;

private:
  Estimator::Ptr estimator_;
};

struct Row {
  std::string estimator; ///< empty: the aligner's own
  std::string correspondences;
  std::vector<std::string> rejectors;
  bool reciprocal;
};

struct End {
  Eigen::Matrix4d transformation;
  int iterations, state;
  bool converged;
  std::vector<Handed> handed;
};

template <typename Icp>
End endOf(const Row& row, const Cloud::Ptr& source, const Cloud::Ptr& target, Icp&& icp = Icp())
{
  struct Counting : Icp {
    static int iterations(const Icp& icp) { return icp.*(&Counting::nr_iterations_); }
  };
  icp.setInputSource(source);
  icp.setInputTarget(target);
  icp.setMaximumIterations(30);
  icp.setTransformationEpsilon(1e-10);
  icp.setMaxCorrespondenceDistance(0.05);
  icp.setUseReciprocalCorrespondences(row.reciprocal);
  pcl::shared_ptr<Spy> spy;
  if (!row.estimator.empty()) {
    spy = pcl::make_shared<Spy>(components::estimator(row.estimator));
    icp.setTransformationEstimation(spy);
  }
  if (const auto estimation = components::correspondenceEstimation(row.correspondences))
    icp.setCorrespondenceEstimation(estimation);
  for (const std::string& rejector : row.rejectors)
    icp.addCorrespondenceRejector(components::rejector(rejector));
  Cloud output;
  icp.align(output);
  return {icp.getFinalTransformation(),
          Counting::iterations(icp),
          icp.getConvergeCriteria()->getConvergenceState(),
          icp.hasConverged(),
          spy ? spy->handed : std::vector<Handed>()};
}

void expectTheSameWasHanded(const End& actual, const End& expected)
{
  ASSERT_EQ(actual.handed.size(), expected.handed.size());
  for (std::size_t i = 0; i < expected.handed.size(); ++i) {
    const Handed &ours = actual.handed[i], &stock = expected.handed[i];
    ASSERT_EQ(ours.source, stock.source) << "iteration " << i;
    ASSERT_EQ(ours.correspondences.size(), stock.correspondences.size()) << "iteration " << i;
    for (std::size_t c = 0; c < stock.correspondences.size(); ++c) {
      ASSERT_EQ(ours.correspondences[c].index_query, stock.correspondences[c].index_query) << "iteration " << i;
      ASSERT_EQ(ours.correspondences[c].index_match, stock.correspondences[c].index_match) << "iteration " << i;
      ASSERT_EQ(ours.correspondences[c].distance, stock.correspondences[c].distance) << "iteration " << i;
    }
  }
}

std::vector<std::vector<std::string>> chainsOfRejectors()
{
  std::vector<std::vector<std::string>> chains = {{},
                                                  {"median", "one to one"},
                                                  {"trimmed", "one to one"},
                                                  {"one to one", "trimmed"},
                                                  {"one to one", "sample consensus"},
                                                  {"distance", "surface normal"}};
  for (const std::string& rejector : components::rejectors)
    chains.push_back({rejector});
  return chains;
}

/// A cloud of the bunny's size, whose normals PCL estimates.
Cloud::Ptr withNormals(const pcl::PointCloud<pcl::PointXYZ>& cloud, float scale)
{
  Cloud::Ptr result(new Cloud);
  for (const auto& point : cloud) {
    Point scaled;
    scaled.getVector3fMap() = scale * point.getVector3fMap();
    result->push_back(scaled);
  }
  pcl::NormalEstimation<Point, Point> normals;
  normals.setKSearch(10);
  normals.setSearchMethod(pcl::make_shared<pcl::search::KdTree<Point>>());
  normals.setInputCloud(result);
  normals.compute(*result);
  return result;
}

Cloud::Ptr everyOther(const scans::Cloud& cloud)
{
  scans::Cloud thinned;
  for (std::size_t i = 0; i < cloud.size(); i += 2)
    thinned.push_back(cloud[i]);
  return withNormals(thinned, 1);
}

template <typename Check>
void forEachRow(const std::string& estimator, const Check& check)
{
  for (const std::string& correspondences : components::correspondences)
    for (const auto& rejectors : chainsOfRejectors())
      for (const bool reciprocal : {false, true}) {
        std::string name = correspondences + (reciprocal ? ", reciprocal" : "");
        for (const std::string& rejector : rejectors)
          name += ", " + rejector;
        SCOPED_TRACE(name);
        check(Row{estimator, correspondences, rejectors, reciprocal});
      }
}

} // namespace

class OnTheBunny : public testing::Test {
protected:
  OnTheBunny()
  {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
    if (scans::areThere()) {
      source = everyOther(*scans::read("bunny_45.pcd"));
      target = everyOther(*scans::read("bunny_0.pcd"));
      return;
    }
    std::cout << "without the bunny of " << scans::folder << ": hills of its size\n";
    const auto by = scenes::smallMotion();
    source = withNormals(*scenes::moved(*scenes::hills<pcl::PointXYZ>(180, 2), by), 0.04F);
    target = withNormals(*scenes::hills<pcl::PointXYZ>(200), 0.04F);
  }
  ~OnTheBunny() override { pcl::console::setVerbosityLevel(pcl::console::L_INFO); }

  Cloud::Ptr source, target;
};

class CallersComponents : public OnTheBunny, public testing::WithParamInterface<std::string> {};

TEST_P(CallersComponents, SeeWhatPclHandsThem)
{
  forEachRow(GetParam(), [&](const Row& row) {
    const End expected = endOf<Stock>(row, source, target), actual = endOf<Ours>(row, source, target);
    EXPECT_EQ(actual.iterations, expected.iterations);
    EXPECT_EQ(actual.state, expected.state);
    EXPECT_EQ(actual.converged, expected.converged);
    EXPECT_TRUE(actual.transformation.isApprox(expected.transformation, 1e-12)) << actual.transformation << '\n'
                                                                                << expected.transformation;
    expectTheSameWasHanded(actual, expected);
  });
}

INSTANTIATE_TEST_SUITE_P(, CallersComponents, testing::ValuesIn(components::estimators), [](const auto& info) {
  return info.param;
});

// The aligner's own estimator works on coordinates that are not rounded anew in each iteration, so its answer is PCL's
// but for that rounding, and a threshold may be met an iteration earlier or later.
TEST_F(OnTheBunny, CallersComponentsWithTheAlignersOwnEstimator)
{
  forEachRow("", [&](const Row& row) {
    const End expected = endOf<Stock>(row, source, target), actual = endOf<Ours>(row, source, target);
    EXPECT_NEAR(actual.iterations, expected.iterations, 3);
    EXPECT_EQ(actual.converged, expected.converged);
    // This one chooses how many pairs stay, so that a rounding may lead to another few.
    const auto& rejectors = row.rejectors;
    const bool jumps = std::find(rejectors.begin(), rejectors.end(), "var trimmed") != rejectors.end();
    EXPECT_LT(scenes::metresBetween<double>(actual.transformation, expected.transformation), jumps ? 1e-4 : 1e-6);
    EXPECT_LT(scenes::degreesBetween<double>(actual.transformation, expected.transformation), jumps ? 0.03 : 1e-4);
  });
}

Eigen::Affine3f turnedALittle()
{
  return Eigen::Translation3f(0.004F, -0.003F, 0.005F) *
         Eigen::AngleAxisf(0.02F, Eigen::Vector3f(1, 2, 3).normalized());
}

/// Rows of a range image, 40 by 30, in which a part and the edge have no return.
Cloud::Ptr organized()
{
  Cloud::Ptr cloud(new Cloud(40, 30));
  cloud->is_dense = false;
  for (unsigned row = 0; row < cloud->height; ++row)
    for (unsigned column = 0; column < cloud->width; ++column) {
      const float x = 0.01F * static_cast<float>(column), y = 0.01F * static_cast<float>(row);
      const bool is_seen = row > 1 && column < 36 && (row < 12 || row > 20 || column < 10 || column > 22);
      Point& point = cloud->at(column, row);
      point.getVector3fMap() << x, y, is_seen ? 0.02F * std::sin(20 * x) * std::cos(15 * y) : NAN;
      point.getNormalVector3fMap() =
          Eigen::Vector3f(-0.4F * std::cos(20 * x) * std::cos(15 * y), 0.3F * std::sin(20 * x) * std::sin(15 * y), 1)
              .normalized();
    }
  return cloud;
}

TEST(CallersComponentsOnRows, TheRejectorOfBoundariesSeesTheTargetsRows)
{
  const Cloud::Ptr target = organized(), source = scenes::moved(*target, turnedALittle());
  pcl::Indices kept;
  pcl::removeNaNFromPointCloud(*source, *source, kept);
  for (const std::string& estimator : components::estimators) {
    SCOPED_TRACE(estimator);
    const auto handedFirst = [&](const std::vector<std::string>& rejectors) {
      const Row row{estimator, "default", rejectors, false};
      const End expected = endOf<Stock>(row, source, target), actual = endOf<Ours>(row, source, target);
      EXPECT_TRUE(actual.transformation.isApprox(expected.transformation, 1e-12));
      expectTheSameWasHanded(actual, expected);
      return expected.handed.at(0).correspondences.size();
    };
    // PCL 1.13's hands on every pair, and those that are not at a boundary once more.
    EXPECT_NE(handedFirst({}), handedFirst({"organized boundary"}));
  }
}
