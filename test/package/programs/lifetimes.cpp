// Aligners, estimators, batches and trees in static storage, behind base classes, derived from, and destroyed in any
// order.
#include "clouds.h"

#include <pcl_gpu_icp/batch.h>
#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/search/kdtree.h>
#include <pcl_gpu_icp/transformation_estimation_svd.h>

#include <iostream>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

using pcl::PointXYZ;
using Icp = pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ>;
using Estimator = pcl_gpu_icp::TransformationEstimationSVD<PointXYZ, PointXYZ>;
using pcl_gpu_icp::CorrespondenceSearch;

// As PCL has it.
using Stock = pcl::IterativeClosestPoint<PointXYZ, PointXYZ>;
static_assert(std::is_copy_constructible_v<Icp> == std::is_copy_constructible_v<Stock>);
static_assert(std::is_move_constructible_v<Icp> == std::is_move_constructible_v<Stock>);
static_assert(std::is_copy_assignable_v<Icp> == std::is_copy_assignable_v<Stock>);

namespace {

int failures = 0;

void expect(bool condition, const char* what)
{
  if (condition)
    return;
  std::cerr << what << '\n';
  ++failures;
}

template <typename Aligner>
bool aligns(Aligner& icp)
{
  icp.setInputSource(hills(shift));
  icp.setInputTarget(hills());
  return findsTheShift(icp);
}

Icp in_static_storage;
pcl_gpu_icp::search::KdTree<PointXYZ> tree_in_static_storage;
std::unique_ptr<Icp> destroyed_at_exit;

struct Derived : Icp {
  int moves = 0;

protected:
  void transformCloud(const Cloud& input, Cloud& output, const Matrix4& transform) override
  {
    ++moves;
    Icp::transformCloud(input, output, transform);
  }
};

std::unique_ptr<Icp> made(CorrespondenceSearch search)
{
  auto icp = std::make_unique<Icp>();
  icp->setCorrespondenceSearch(search);
  return icp;
}

} // namespace

int main()
{
  expect(aligns(in_static_storage), "in static storage");
  tree_in_static_storage.setInputCloud(hills());
  destroyed_at_exit = std::make_unique<Icp>();
  expect(aligns(*destroyed_at_exit), "destroyed at exit");

  const pcl::Registration<PointXYZ, PointXYZ>::Ptr registration(new Icp);
  expect(aligns(*registration), "through pcl::Registration");
  std::unique_ptr<Stock> stock(new Icp);
  expect(aligns(*stock), "through pcl::IterativeClosestPoint");
  stock.reset();

  Derived derived;
  expect(aligns(derived) && derived.moves > 0, "derived from");

  for (const auto search : {CorrespondenceSearch::PclKdTree, CorrespondenceSearch::DeviceKdTree}) {
    auto first = made(search), second = made(search);
    expect(aligns(*first) && aligns(*second), "one beside another");
    first = std::move(second);
    expect(aligns(*first), "after another was destroyed");
  }

  std::vector<std::unique_ptr<Icp>> many;
  for (int i = 0; i < 4; ++i) {
    many.push_back(std::make_unique<Icp>());
    expect(aligns(*many.back()), "one of many");
  }
  many.erase(many.begin());
  expect(aligns(*many.front()), "after the first was destroyed");

  // The aligner outlives what it was given, and the estimator the aligner.
  const Estimator::Ptr estimator(new Estimator);
  {
    Stock icp;
    icp.setTransformationEstimation(estimator);
    expect(aligns(icp), "estimator in PCL's aligner");
  }
  Eigen::Matrix4f matrix;
  estimator->estimateRigidTransformation(*hills(shift), *hills(), matrix);
  expect((matrix.topRightCorner<3, 1>() + shift).norm() < 1e-5F, "estimator after its aligner");

  auto batch = std::make_unique<pcl_gpu_icp::BatchAligner>();
  batch->add<PointXYZ, PointXYZ>(hills(shift), hills());
  const auto results = batch->run();
  batch.reset();
  expect((pcl_gpu_icp::toMatrix(results[0].transform).topRightCorner<3, 1>() + shift).norm() < 0.01F,
         "results after their batch");
  return failures > 0 ? 1 : 0;
}
