// A launch of more work-items than the device is given at once runs in passes, and what comes out is the bits of the
// whole launch: of everything that has kernels, on every device, kernel shape and precision.
#include "device_cases.h"
#include "engine/estimator_internals.h"
#include "engine/matcher_internals.h"
#include "engine/neighbour_search_internals.h"
#include "engine/normal_estimator_internals.h"
#include "engine/plane_estimator_internals.h"
#include "estimator_cases.h"
#include "reference.h"

#include <pcl_gpu_icp/point_covariances.h>

#include <cstring>

namespace pcl_gpu_icp::test {

namespace {

PointCovariances covariancesAlong(const Cloud& directions)
{
  NormalEstimator::Normals normals;
  for (Eigen::Index i = 0; i < directions.cols(); ++i)
    normals.push_back({directions(0, i), directions(1, i), directions(2, i)});
  return surfaceCovariances(normals, 0.001);
}

} // namespace

class Passes : public OnDevice {
protected:
  /// That a launch has whole, a work-group at a time, and in passes of three, of which the last one is smaller.
  std::vector<opencl::Traits> everyTraits() const
  {
    const opencl::Traits& whole = GetParam().traits;
    std::vector<opencl::Traits> traits(3, whole);
    traits[1].max_work_items = 1;
    traits[2].max_work_items = 3 * (whole.shape == opencl::Shape::Chunked ? 1 : whole.work_group_size);
    return traits;
  }

  /// Calls `result` with each of them and compares what it returns.
  template <typename Result, typename Same>
  void expectTheSame(const Result& result, const Same& same)
  {
    const auto whole = result(GetParam().traits);
    for (const opencl::Traits& traits : everyTraits())
      EXPECT_TRUE(same(result(traits), whole)) << "at most " << traits.max_work_items << " work-items at once";
  }

  const Device& device() const { return GetParam().device; }
  Precision precision() const { return GetParam().precision; }

  Random random_{1};
  // Blocks of 2048 points and of 256, the last of each not full.
  const Cloud target_ = random_.cloud(GetParam().affordable(7 * 1024 + 100));
  const Cloud source_ = moved(target_, motion({1, 2, 3}, 0.01, {0.05, -0.03, 0.02}));
  const Cloud normals_ = random_.directions(target_.cols());
};

TEST_P(Passes, OfBothPipelines)
{
  for (const Pipeline pipeline : {Pipeline::Staged, Pipeline::Fused})
    expectTheSame(
        [&](const opencl::Traits& traits) {
          return makeEstimator(device(), traits, pipeline, precision()).estimate(viewOf(source_), viewOf(target_));
        },
        identical);
}

TEST_P(Passes, OfPointToPlaneEstimation)
{
  expectTheSame(
      [&](const opencl::Traits& traits) {
        return makePlaneEstimator(device(), traits, precision())
            .estimate(viewOf(source_), viewOf(target_), viewOf(normals_));
      },
      identical);
}

TEST_P(Passes, OfMatching)
{
  const auto index = std::make_shared<search::NearestIndex>();
  index->build(viewOf(target_));
  const PointCovariances of_target = covariancesAlong(normals_);
  const Cloud source_normals = random_.directions(source_.cols());
  const PointCovariances of_source = covariancesAlong(source_normals);
  for (const bool device_searches : {false, true})
    for (const Metric metric : {Metric::Point, Metric::Plane, Metric::Symmetric, Metric::Generalized}) {
      if (device_searches && !GetParam().searches())
        continue;
      SCOPED_TRACE(std::string(device_searches ? "device" : "host") + ", " + toString(metric));
      expectTheSame(
          [&](const opencl::Traits& traits) {
            Matcher matcher = makeMatcher(device(), traits, precision());
            matcher.setTarget(device_searches ? matcher.makeTarget(viewOf(target_)) : matcher.makeTarget(index));
            if (metric == Metric::Plane || metric == Metric::Symmetric)
              matcher.setTargetNormals(viewOf(normals_));
            if (metric == Metric::Generalized)
              matcher.setTargetCovariances({of_target.data(), of_target.size(), sizeof(of_target[0])});
            matcher.setSource(viewOf(source_));
            if (metric == Metric::Symmetric)
              matcher.setSourceNormals(viewOf(source_normals));
            if (metric == Metric::Generalized)
              matcher.setSourceCovariances({of_source.data(), of_source.size(), sizeof(of_source[0])});
            matcher.match({}, 1.0F); // the next one has candidates
            return matcher.match(transformOf(motion({0, 0, 1}, 0.01, {0.02, 0, 0})), 1.0F);
          },
          [](const Matches& a, const Matches& b) {
            return a.searched == b.searched && a.mean_squared_distance == b.mean_squared_distance &&
                   a.mean_squared_residual == b.mean_squared_residual && identical(a.increment, b.increment);
          });
    }
}

TEST_P(Passes, OfNormals)
{
  if (GetParam().searches())
    expectTheSame(
        [&](const opencl::Traits& traits) {
          return makeNormalEstimator(device(), traits, precision()).estimate(viewOf(target_), 8);
        },
        [](const auto& a, const auto& b) {
          return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
        });
}

TEST_P(Passes, OfASearch)
{
  if (GetParam().searches())
    expectTheSame(
        [&](const opencl::Traits& traits) {
          NeighbourSearch search = makeNeighbourSearch(device(), traits);
          search.build(viewOf(target_));
          return search.nearest(viewOf(source_), 5);
        },
        [](const auto& a, const auto& b) {
          return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Neighbours& x, const Neighbours& y) {
            return x.positions == y.positions && x.squared_distances == y.squared_distances;
          });
        });
}

INSTANTIATE_TEST_SUITE_P(, Passes, testing::ValuesIn(wholeCases()), nameOf<DeviceCase>);

} // namespace pcl_gpu_icp::test
