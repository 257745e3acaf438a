#include "centroid.h"

#include "kernels/layout.h"
#include "launch.h"

namespace pcl_gpu_icp::stages {

StageRequest Centroid::request(std::size_t pairs)
{
  StageRequest request{"centroid", {pairs}};
  const auto levels = halvings(pairs);
  request.work_items.insert(request.work_items.end(), levels.begin(), levels.end());
  return request;
}

void Centroid::enqueue(opencl::Queue& queue, const Pairs& pairs, std::size_t real_bytes, const opencl::Buffer& solution)
{
  queue.reserve(rows_, std::size_t(PAIR_ROWS) * pairs.stride * real_bytes);
  queue.launch("centroid",
               {"centroid.cl", "centroid_widen"},
               overPoints(queue.traits(), pairs.stride, PAIR_ROWS),
               pairs.rows,
               pairs.stride,
               rows_);
  const opencl::Buffer& sums = sum_.enqueue(queue, rows_, pairs.stride, PAIR_ROWS, pairs.count, real_bytes);
  queue.launch(
      "centroid", {"centroid.cl", "centroid_mean"}, workItems(PAIR_ROWS), sums, pairs.stride, pairs.count, solution);
}

} // namespace pcl_gpu_icp::stages
