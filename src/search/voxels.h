#pragma once

#include <pcl_gpu_icp/points.h>

#include <cstddef>
#include <vector>

namespace pcl_gpu_icp::search {

/// The means of the points in each voxel of a grid, in an order that depends on the points alone; positions count them.
/// \param size of a voxel; what is beyond 2^20 voxels from 0 is left out
std::vector<PlacedPoint> voxelMeans(const std::vector<PlacedPoint>& points, double size);

/// The size of voxels of which about so many have points, each `fewest_each` of them on average at least: finer voxels
/// hold a point each; 0 where all are at one place.
double voxelSizeFor(const std::vector<PlacedPoint>& points, std::size_t voxels, double fewest_each = 2);

} // namespace pcl_gpu_icp::search
