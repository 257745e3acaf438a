// Packing: which points reach the device, and about which pivot.
#include "stages/pack.h"

#include "stage_rig.h"

#include <limits>

namespace pcl_gpu_icp::test {

namespace {

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

} // namespace

TEST(Pivot, LiesAmongThePoints)
{
  Random random(1);
  for (const std::size_t n : {1, 2, 3, 62, 63, 64, 1000}) {
    const Cloud cloud = random.cloud(n, {10, 10, 10}, {500'000, 5'000'000, 100});
    const stages::Pivot pivot = stages::placementOf(viewOf(cloud)).pivot;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(pivot[axis], cloud.row(axis).minCoeff());
      EXPECT_LE(pivot[axis], cloud.row(axis).maxCoeff());
      EXPECT_EQ(pivot[axis], double(float(pivot[axis]))) << "a coordinate, so that differences to it are exact";
    }
  }
}

TEST(Pivot, IsNotDrawnAwayByAFewFarPoints)
{
  Random random(2);
  Cloud cloud = random.cloud(630);
  for (int i = 0; i < 200; i += 1)
    cloud.col(3 * i) *= 1e6F;
  const stages::Pivot pivot = stages::placementOf(viewOf(cloud)).pivot;
  EXPECT_LE(std::abs(pivot[0]), 20);
}

TEST(Pivot, IgnoresWhatIsNotFinite)
{
  Cloud cloud = Cloud::Constant(3, 200, not_a_number);
  EXPECT_EQ(stages::placementOf(viewOf(cloud)).pivot, stages::Pivot{});
  cloud.col(7) = Eigen::Vector3f(1, 2, 3);
  EXPECT_EQ(stages::placementOf(viewOf(cloud)).pivot, (stages::Pivot{1, 2, 3}));
  cloud.col(9) = Eigen::Vector3f(4, infinity, 5);
  EXPECT_EQ(stages::placementOf(viewOf(cloud)).pivot, (stages::Pivot{1, 2, 3}));
}

TEST(Pivot, OfNothingIsTheOrigin) { EXPECT_EQ(stages::placementOf(Points{}).pivot, stages::Pivot{}); }

TEST(Rounding, IsHalfAUnitInTheLastPlaceOfTheLargestCoordinate)
{
  Random random(3);
  for (const double offset : {0.0, 1e3, 5e5}) {
    const Cloud cloud = random.cloud(1000, {1, 1, 1}, {offset, -offset, 0});
    const double largest = cloud.cwiseAbs().maxCoeff();
    const double rounding = stages::placementOf(viewOf(cloud)).rounding;
    EXPECT_LE(rounding, largest * 5.97e-8);
    EXPECT_GE(rounding, 0.9 * largest * 5.96e-8);
  }
  EXPECT_EQ(stages::placementOf(viewOf(Cloud::Zero(3, 5))).rounding, 0);
}

class Pack : public OnDevice {
protected:
  /// Rows of n columns from a buffer of rows of `stride` floats.
  Eigen::MatrixXf rowsOf(const opencl::Buffer& buffer, int rows, std::size_t stride)
  {
    const auto values = rig_.readFloats(buffer, rows * stride);
    return Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        values.data(), rows, stride);
  }

  StageRig rig_{GetParam()};
};

TEST_P(Pack, PairsAreKeptAboutTheirPivots)
{
  Random random(3);
  for (const std::size_t n : {1, 15, 16, 17, 100}) {
    const Cloud source = random.cloud(n, {10, 10, 10}, {500'000, 5'000'000, 100}), target = random.cloud(n);
    const stages::Placement p = stages::placementOf(viewOf(source)), q = stages::placementOf(viewOf(target));
    stages::packPairs(rig_.queue, viewOf(source), viewOf(target), p, q, rig_.pairs);
    ASSERT_EQ(rig_.pairs.count, n);
    ASSERT_EQ(rig_.pairs.stride % ROW_PADDING, 0U);
    ASSERT_GE(rig_.pairs.stride, n);
    const auto rows = rowsOf(rig_.pairs.rows, PAIR_ROWS, rig_.pairs.stride);
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t i = 0; i < n; ++i) {
        EXPECT_EQ(rows(axis, i), float(double(source(axis, i)) - p.pivot[axis]));
        EXPECT_EQ(rows(3 + axis, i), float(double(target(axis, i)) - q.pivot[axis]));
      }
    EXPECT_TRUE((rows.rightCols(rows.cols() - n).array() == 0).all()) << "padding";
    EXPECT_FLOAT_EQ(rig_.pairs.resolution_sq, p.rounding * q.rounding);
  }
}

TEST_P(Pack, PairsWithANonFinitePointAreLeftOut)
{
  Random random(4);
  Cloud source = random.cloud(200), target = random.cloud(200);
  source(0, 0) = not_a_number;
  source(1, 5) = infinity;
  source(2, 6) = -infinity;
  target(2, 6) = not_a_number;
  target(0, 64) = -not_a_number;
  target(1, 127) = -infinity;
  source(1, 199) = infinity;
  const std::vector<std::size_t> out = {0, 5, 6, 64, 127, 199};
  stages::packPairs(rig_.queue, viewOf(source), viewOf(target), {}, {}, rig_.pairs);
  ASSERT_EQ(rig_.pairs.count, 200 - out.size());
  const auto rows = rowsOf(rig_.pairs.rows, PAIR_ROWS, rig_.pairs.stride);
  std::size_t k = 0;
  for (std::size_t i = 0; i < 200; ++i) {
    if (std::find(out.begin(), out.end(), i) != out.end())
      continue;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(rows(axis, k), source(axis, i));
      EXPECT_EQ(rows(3 + axis, k), target(axis, i));
    }
    ++k;
  }
  EXPECT_TRUE((rows.rightCols(rows.cols() - k).array() == 0).all()) << "padding";
}

TEST_P(Pack, ReadsThroughAnIndexOfAnyStride)
{
  Random random(5);
  const Cloud cloud = random.cloud(10);
  const std::vector<Correspondence> correspondences = {{3, 9, 0.5F}, {3, 0, 0}, {7, 2, 1}};
  Points source = viewOf(cloud), target = viewOf(cloud);
  source.count = target.count = correspondences.size();
  source.index = &correspondences[0].source;
  target.index = &correspondences[0].target;
  source.index_stride = target.index_stride = sizeof(Correspondence);
  stages::packPairs(rig_.queue, source, target, {}, {}, rig_.pairs);
  ASSERT_EQ(rig_.pairs.count, 3U);
  const auto rows = rowsOf(rig_.pairs.rows, PAIR_ROWS, rig_.pairs.stride);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(Eigen::Vector3f(rows.block<3, 1>(0, k)), Eigen::Vector3f(cloud.col(correspondences[k].source)));
    EXPECT_EQ(Eigen::Vector3f(rows.block<3, 1>(3, k)), Eigen::Vector3f(cloud.col(correspondences[k].target)));
  }
}

TEST_P(Pack, ReadsPointsOfAnyStride)
{
  Random random(6);
  const Eigen::MatrixXf wide = Eigen::MatrixXf::Random(12, 20);
  const Points points{wide.data(), 20, 12 * sizeof(float), nullptr, 0};
  stages::Cloud cloud;
  stages::packCloud(rig_.queue, points, {}, cloud);
  EXPECT_EQ(rowsOf(cloud.rows, 3, cloud.stride).leftCols(20), wide.topRows(3));
}

TEST_P(Pack, ACloudsNonFinitePointsKeepTheirPlace)
{
  Random random(7);
  Cloud points = random.cloud(33);
  points(1, 4) = not_a_number;
  points(2, 8) = infinity;
  stages::Cloud cloud;
  const stages::Placement placement = stages::placementOf(viewOf(points));
  stages::packCloud(rig_.queue, viewOf(points), placement, cloud);
  ASSERT_EQ(cloud.count, 33U);
  const auto rows = rowsOf(cloud.rows, 3, cloud.stride);
  for (int i = 0; i < 33; ++i)
    for (int axis = 0; axis < 3; ++axis)
      if (std::isfinite(points(axis, i))) {
        EXPECT_EQ(rows(axis, i), float(double(points(axis, i)) - placement.pivot[axis]));
      }
}

TEST_P(Pack, AnEmptyCloudIsNoError)
{
  stages::Cloud cloud;
  EXPECT_NO_THROW(stages::packCloud(rig_.queue, Points{}, {}, cloud));
  EXPECT_EQ(cloud.count, 0U);
}

RUN_WITH_EVERY_MEMORY(Pack);

} // namespace pcl_gpu_icp::test
