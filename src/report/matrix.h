#pragma once

#include <pcl_gpu_icp/rigid_transform.h>

#include <array>
#include <string>

namespace pcl_gpu_icp::report {

using Matrix4 = std::array<std::array<double, 4>, 4>;

Matrix4 toMatrix(const RigidTransform& transform);

/// Four lines of four numbers with every digit of a double.
std::string matrixFile(const RigidTransform& transform);

/// How far it shifts and which way, and by how much it turns about which axis. The shift is the matrix's, or that of
/// the points' middle where the matrix's is mostly the turn about a far origin.
std::string motionText(const RigidTransform& transform, const std::array<double, 3>& centroid);

/// Four indented lines of four aligned columns, for reading.
std::string matrixText(const RigidTransform& transform);

} // namespace pcl_gpu_icp::report
