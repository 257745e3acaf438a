#include "launch.h"

#include "kernels/layout.h"

namespace pcl_gpu_icp::stages {

using opencl::Shape;
using opencl::Traits;
using opencl::WorkSize;

namespace {

std::size_t quotientRoundedUp(std::size_t n, std::size_t divisor) { return (n + divisor - 1) / divisor; }

} // namespace

cl_uint paddedStride(std::size_t n) { return static_cast<cl_uint>(quotientRoundedUp(n, ROW_PADDING) * ROW_PADDING); }

Precision available(Precision wanted, const Traits& traits) { return traits.fp64 ? wanted : Precision::Float; }

std::string buildOptions(const Traits& traits, Precision precision)
{
  std::string options = "-cl-std=CL1.2";
  options += traits.shape == Shape::Chunked ? std::string(" -DCHUNKED")
                                            : " -DWORK_GROUP_SIZE=" + std::to_string(traits.work_group_size);
  if (precision == Precision::Double)
    options += " -DREAL_IS_DOUBLE";
  return options;
}

WorkSize overPoints(const Traits& traits, std::size_t n, std::size_t rows)
{
  if (traits.shape == Shape::Chunked)
    return {cl::NDRange(quotientRoundedUp(n, POINTS_PER_BLOCK), rows), cl::NDRange(1, 1)};
  const std::size_t group = traits.work_group_size;
  return {cl::NDRange(quotientRoundedUp(n, group) * group, rows), cl::NDRange(group, 1)};
}

WorkSize overPoints(const Traits& traits, std::size_t n)
{
  if (traits.shape == Shape::Chunked)
    return {cl::NDRange(quotientRoundedUp(n, POINTS_PER_BLOCK)), cl::NDRange(1)};
  const std::size_t group = traits.work_group_size;
  return {cl::NDRange(quotientRoundedUp(n, group) * group), cl::NDRange(group)};
}

WorkSize overBlocks(const Traits& traits, std::size_t blocks)
{
  const std::size_t group = traits.shape == Shape::Chunked ? 1 : traits.work_group_size;
  return {cl::NDRange(blocks * group), cl::NDRange(group)};
}

WorkSize oneGroup(const Traits& traits, std::size_t items)
{
  const std::size_t group = traits.shape == Shape::Chunked ? 1 : items;
  return {cl::NDRange(group), cl::NDRange(group)};
}

WorkSize workItems(std::size_t items) { return {cl::NDRange(items), cl::NDRange(1)}; }

cl_float16 rowsOf(const RigidTransform& transform)
{
  cl_float16 rows{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      rows.s[4 * i + j] = static_cast<float>(transform.rotation[3 * i + j]);
    rows.s[4 * i + 3] = static_cast<float>(transform.translation[i]);
  }
  return rows;
}

std::vector<std::size_t> halvings(std::size_t n)
{
  std::vector<std::size_t> levels;
  while (n > 1)
    levels.push_back(n = (n + 1) / 2);
  return levels;
}

} // namespace pcl_gpu_icp::stages
