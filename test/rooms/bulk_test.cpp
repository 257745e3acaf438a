// Where most of a cloud lies, whatever a few of its points are.
#include "search/bulk.h"

#include "reference.h"
#include "search/box_tree.h"

#include <gtest/gtest.h>

#include <limits>

namespace pcl_gpu_icp::search {

using test::Cloud;
using test::Random;
using test::viewOf;

TEST(Bulk, HoldsEveryPointOfACloudWithoutStrays)
{
  Random random(1);
  for (const std::size_t n : {1, 2, 3, 4, 5, 63, 64, 1000}) {
    const Cloud cloud = random.cloud(n, {10, 1, 0}, {5e5, 0, 3});
    const Bulk bulk(viewOf(cloud));
    for (std::size_t i = 0; i < n; ++i)
      EXPECT_TRUE(bulk.holds(cloud.col(int(i)).data()));
    EXPECT_EQ(bulk.largest(viewOf(cloud))[0], cloud.row(0).maxCoeff());
  }
}

TEST(Bulk, LeavesOutWhatIsFarFromAllOthers)
{
  Random random(2);
  for (const std::size_t n : {5, 30, 63, 64, 1000})
    for (const float far : {1e5F, -1e10F, 1e17F, 1e20F, 3.3e38F, std::numeric_limits<float>::quiet_NaN()}) {
      Cloud cloud = random.cloud(n);
      cloud(1, 0) = far;
      const Bulk bulk(viewOf(cloud));
      EXPECT_FALSE(bulk.holds(cloud.col(0).data()));
      EXPECT_TRUE(bulk.holds(cloud.col(1).data()));
      EXPECT_LE(bulk.largest(viewOf(cloud))[1], 10);
    }
}

TEST(Bulk, OfPointsMostlyAtOnePlaceHoldsAll)
{
  Cloud cloud = Cloud::Zero(3, 10);
  cloud.col(4) << 1, 2, 3;
  EXPECT_TRUE(Bulk(viewOf(cloud)).holds(cloud.col(4).data()));
}

TEST(PivotOf, IsNotDrawnAwayByAStray)
{
  Random random(3);
  Cloud cloud = random.cloud(50, {5, 5, 5}, {4e5, 5e6, 1});
  const auto expected = pivotOf(viewOf(cloud));
  EXPECT_NE(expected[0], 0);
  for (const float far : {1e12F, -1e17F, 1e30F}) {
    cloud.col(7).setConstant(far);
    const auto pivot = pivotOf(viewOf(cloud));
    EXPECT_NEAR(pivot[0], expected[0], 10);
    EXPECT_NEAR(pivot[1], expected[1], 10);
    EXPECT_EQ(pivot[2], 0);
  }
}

TEST(TakesPart, UpToWhereSquaresAreFinite)
{
  const float limit = largest_coordinate, beyond = std::nextafter(limit, 2 * limit);
  for (int axis = 0; axis < 3; ++axis)
    for (const float sign : {-1.0F, 1.0F}) {
      Cloud cloud = Cloud::Zero(3, 2);
      cloud(axis, 1) = sign * limit;
      EXPECT_EQ(finitePoints(viewOf(cloud), {}, 1).size(), 2U);
      cloud(axis, 1) = sign * beyond;
      EXPECT_EQ(finitePoints(viewOf(cloud), {}, 1).size(), 1U);
    }
  // Between opposite corners.
  const float difference = 2 * limit;
  EXPECT_TRUE(std::isfinite(3 * difference * difference));
}

} // namespace pcl_gpu_icp::search
