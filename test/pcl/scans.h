#pragma once

#include <pcl/filters/filter.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/io/pcd_io.h>

#include <filesystem>
#include <stdexcept>

// The real scans that tests compare on, where they are.
namespace scans {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

inline const std::filesystem::path folder = PCL_GPU_ICP_SHARED_DATA;

inline bool areThere() { return std::filesystem::exists(folder); }

/// The finite points of a scan, or the means of those in each voxel of `leaf` metres.
inline Cloud::Ptr read(const std::string& name, float leaf = 0)
{
  Cloud::Ptr cloud(new Cloud), filtered(new Cloud);
  if (pcl::io::loadPCDFile((folder / name).string(), *cloud) != 0)
    throw std::runtime_error("cannot read " + name);
  cloud->is_dense = false;
  pcl::Indices kept;
  pcl::removeNaNFromPointCloud(*cloud, *filtered, kept);
  if (leaf <= 0)
    return filtered;
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setLeafSize(leaf, leaf, leaf);
  grid.setInputCloud(filtered);
  grid.filter(*cloud);
  return cloud;
}

} // namespace scans
