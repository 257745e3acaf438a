#include "report/difference.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pcl_gpu_icp::report {
namespace {

RigidTransform turnAboutZ(double degrees, double x = 0)
{
  const double radians = degrees * 3.14159265358979323846 / 180;
  const double c = std::cos(radians);
  const double s = std::sin(radians);
  return {{c, -s, 0, s, c, 0, 0, 0, 1}, {x, 0, 0}};
}

TEST(Difference, DegreesAtEverySize)
{
  for (const double degrees : {180.0, 90.0, 10.0, 1e-3, 1e-6, 1e-9})
    EXPECT_NEAR(differenceOf(turnAboutZ(30), turnAboutZ(30 + degrees), {}).degrees, degrees, 1e-6 * degrees + 1e-13);
  EXPECT_EQ(differenceOf(turnAboutZ(30), turnAboutZ(30), {}).degrees, 0);
}

TEST(Difference, MetresAtTheCentroid)
{
  EXPECT_NEAR(differenceOf(turnAboutZ(0), turnAboutZ(0, 0.25), {100, 200, 300}).metres, 0.25, 1e-12);
  // A rotation of 60 degrees moves a point by its distance from the axis.
  EXPECT_NEAR(differenceOf(turnAboutZ(0), turnAboutZ(60), {3, 4, 100}).metres, 5, 1e-12);
}

} // namespace
} // namespace pcl_gpu_icp::report
