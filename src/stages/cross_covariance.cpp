#include "cross_covariance.h"

#include "launch.h"

namespace pcl_gpu_icp::stages {

namespace {

constexpr std::size_t matrix_entries = 9;

} // namespace

StageRequest CrossCovariance::request(std::size_t pairs)
{
  StageRequest request{"cross_covariance", {pairs}};
  const auto levels = halvings(pairs);
  request.work_items.insert(request.work_items.end(), levels.begin(), levels.end());
  return request;
}

void CrossCovariance::enqueue(opencl::Queue& queue,
                              const Pairs& pairs,
                              const opencl::Buffer& demeaned,
                              std::size_t real_bytes,
                              const opencl::Buffer& solution)
{
  queue.reserve(products_, matrix_entries * pairs.stride * real_bytes);
  queue.launch("cross_covariance",
               {"cross_covariance.cl", "outer_products"},
               overPoints(queue.traits(), pairs.stride, matrix_entries),
               demeaned,
               pairs.stride,
               products_);
  const opencl::Buffer& sums = sum_.enqueue(queue, products_, pairs.stride, matrix_entries, pairs.count, real_bytes);
  queue.launch("cross_covariance",
               {"cross_covariance.cl", "store_covariance"},
               workItems(matrix_entries),
               sums,
               pairs.stride,
               solution);
}

} // namespace pcl_gpu_icp::stages
