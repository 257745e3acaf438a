#pragma once

#include "opencl/queue.h"
#include "pairs.h"

#include <pcl_gpu_icp/result.h>
#include <pcl_gpu_icp/rigid_transform.h>

#include <string>

namespace pcl_gpu_icp::stages {

/// The precision that the device computes in when `wanted`: float without fp64.
Precision available(Precision wanted, const opencl::Traits& traits);

/// Build options of all stages for a kernel shape and precision.
std::string buildOptions(const opencl::Traits& traits, Precision precision);

/// Over n points in each of `rows` rows: a work-item per point, or per chunk of points.
opencl::WorkSize overPoints(const opencl::Traits& traits, std::size_t n, std::size_t rows);
opencl::WorkSize overPoints(const opencl::Traits& traits, std::size_t n);

/// Over blocks of POINTS_PER_BLOCK points: a work-group per block, or a work-item.
opencl::WorkSize overBlocks(const opencl::Traits& traits, std::size_t blocks);

/// One work-group of `items` work-items, or one work-item that does their work.
opencl::WorkSize oneGroup(const opencl::Traits& traits, std::size_t items);

/// `items` work-items of equal work, in both shapes.
opencl::WorkSize workItems(std::size_t items);

/// The rows of [R | t] as float32.
cl_float16 rowsOf(const RigidTransform& transform);

/// ceil(n / 2), ceil(n / 4), ... 1: the work-items that each level of a pairwise sum of n values asks for.
std::vector<std::size_t> halvings(std::size_t n);

} // namespace pcl_gpu_icp::stages
