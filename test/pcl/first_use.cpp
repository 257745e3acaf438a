// first_use THREADS WHAT: threads whose first use of OpenCL starts at the same moment. Succeeds where each gets the
// same answer.
#include "scenes.h"

#include "../rooms/watchdog.h"

#include <pcl_gpu_icp/batch.h>
#include <pcl_gpu_icp/icp.h>
#include <pcl_gpu_icp/transformation_estimation_svd.h>

#include <atomic>
#include <functional>
#include <iostream>
#include <map>
#include <string>
#include <thread>
#include <vector>

using pcl::PointXYZ;
using Cloud = pcl::PointCloud<PointXYZ>;
using Matrices = std::vector<Eigen::Matrix4f, Eigen::aligned_allocator<Eigen::Matrix4f>>;
using pcl_gpu_icp::CorrespondenceSearch;

namespace {

const Cloud::Ptr target = scenes::hills<PointXYZ>(400);
const Cloud::Ptr source = scenes::moved(*scenes::hills<PointXYZ>(300, 2), scenes::smallMotion());

Eigen::Matrix4f alignBy(CorrespondenceSearch search)
{
  pcl_gpu_icp::IterativeClosestPoint<PointXYZ, PointXYZ> icp;
  icp.setCorrespondenceSearch(search);
  icp.setMaximumIterations(5);
  icp.setInputSource(source);
  icp.setInputTarget(target);
  Cloud aligned;
  icp.align(aligned);
  return icp.hasConverged() ? icp.getFinalTransformation() : Eigen::Matrix4f::Zero();
}

Eigen::Matrix4f alignInBatch()
{
  pcl_gpu_icp::BatchAligner batch;
  for (int pair = 0; pair < 2; ++pair)
    batch.add<PointXYZ, PointXYZ>(source, target, [](auto& icp) { icp.setMaximumIterations(5); });
  const auto results = batch.run();
  return results[0].alignment.converged ? pcl_gpu_icp::toMatrix(results[0].transform) : Eigen::Matrix4f::Zero();
}

Eigen::Matrix4f estimate()
{
  Eigen::Matrix4f found = Eigen::Matrix4f::Zero();
  const pcl_gpu_icp::TransformationEstimationSVD<PointXYZ, PointXYZ> estimator;
  const auto moved = scenes::moved(*source, scenes::smallMotion());
  estimator.estimateRigidTransformation(*source, *moved, found);
  return found;
}

Eigen::Matrix4f partition()
{
  const auto device = pcl_gpu_icp::Device::select("cpu");
  return Eigen::Matrix4f::Constant(static_cast<float>(device.partition(1).size()));
}

const std::map<std::string, std::function<Eigen::Matrix4f()>> uses = {
    {"pcl", [] { return alignBy(CorrespondenceSearch::PclKdTree); }},
    {"device", [] { return alignBy(CorrespondenceSearch::DeviceKdTree); }},
    {"batch", alignInBatch},
    {"estimator", estimate},
    {"partition", partition},
};

} // namespace

int main(int argc, char** argv)
{
  if (argc != 3 || uses.count(argv[2]) == 0) {
    std::cerr << "usage: first_use THREADS pcl|device|batch|estimator|partition\n";
    return 2;
  }
  const pcl_gpu_icp::test::Watchdog watchdog;
  const auto& use = uses.at(argv[2]);
  const int count = std::stoi(argv[1]);
  Matrices found(count, Eigen::Matrix4f::Zero());
  std::atomic<int> waiting{count};
  std::vector<std::thread> threads;
  for (int i = 0; i < count; ++i)
    threads.emplace_back([&, i] {
      --waiting;
      while (waiting > 0)
        std::this_thread::yield();
      try {
        found[i] = use();
      } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
      }
    });
  for (std::thread& thread : threads)
    thread.join();
  int wrong = 0;
  for (const Eigen::Matrix4f& matrix : found)
    wrong += matrix.isZero() || matrix != found.front() ? 1 : 0;
  if (wrong > 0)
    std::cerr << wrong << " of " << count << " threads got another answer\n";
  return wrong > 0 ? 1 : 0;
}
