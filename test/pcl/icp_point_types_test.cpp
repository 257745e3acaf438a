// Point types: intensities, colours and normals, and a type of the caller's own.
#define PCL_NO_PRECOMPILE
#include "parity.h"

struct Stamped {
  PCL_ADD_POINT4D;
  double stamp;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
} EIGEN_ALIGN16;
POINT_CLOUD_REGISTER_POINT_STRUCT(Stamped, (float, x, x)(float, y, y)(float, z, z)(double, stamp, stamp))

namespace {

template <typename PointT>
void label(PointT&, int)
{
}
void label(pcl::PointXYZI& point, int i) { point.intensity = float(i); }
void label(Stamped& point, int i) { point.stamp = i; }
void label(pcl::PointXYZRGBNormal& point, int i)
{
  point.r = std::uint8_t(i);
  point.getNormalVector3fMap() = Eigen::Vector3f(1, 2, float(i % 7)).normalized();
}
void label(pcl::PointNormal& point, int i)
{
  point.getNormalVector3fMap() = Eigen::Vector3f(1, 2, float(i % 7)).normalized();
}

template <typename PointT>
bool sameLabel(const PointT&, const PointT&)
{
  return true;
}
bool sameLabel(const pcl::PointXYZI& a, const pcl::PointXYZI& b) { return a.intensity == b.intensity; }
bool sameLabel(const Stamped& a, const Stamped& b) { return a.stamp == b.stamp; }
bool sameLabel(const pcl::PointXYZRGBNormal& a, const pcl::PointXYZRGBNormal& b)
{
  return a.r == b.r && (a.getNormalVector3fMap() - b.getNormalVector3fMap()).norm() < 2e-3;
}
bool sameLabel(const pcl::PointNormal& a, const pcl::PointNormal& b)
{
  return (a.getNormalVector3fMap() - b.getNormalVector3fMap()).norm() < 2e-3;
}

template <typename PointT>
class PointTypes : public testing::Test {
};

using Types = testing::Types<pcl::PointXYZ, pcl::PointXYZI, pcl::PointXYZRGBNormal, pcl::PointNormal, Stamped>;
TYPED_TEST_SUITE(PointTypes, Types);

} // namespace

TYPED_TEST(PointTypes, SameAsStockAndEveryFieldKept)
{
  auto target = scenes::hills<TypeParam>(1500);
  auto source = scenes::moved(*scenes::hills<TypeParam>(1200, 3), scenes::smallMotion());
  for (int i = 0; i < int(source->size()); ++i)
    label((*source)[i], i);
  const auto configure = [](auto& icp) { icp.setMaximumIterations(20); };
  expectSameAsStock(source, target, configure);

  pcl::IterativeClosestPoint<TypeParam, TypeParam> stock;
  pcl_gpu_icp::IterativeClosestPoint<TypeParam, TypeParam> ours;
  const Eigen::Matrix4f guess = Eigen::Matrix4f::Identity();
  const auto expected = alignWith(stock, source, target, configure, guess);
  const auto actual = alignWith(ours, source, target, configure, guess);
  for (std::size_t i = 0; i < source->size(); ++i)
    ASSERT_TRUE(sameLabel(actual.output[i], expected.output[i])) << i;
}
