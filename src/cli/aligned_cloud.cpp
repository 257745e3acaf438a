#include "cli/aligned_cloud.h"

namespace pcl_gpu_icp::cli {

void transform(Cloud& cloud, const RigidTransform& transform, bool keep_zero_returns)
{
  const auto xyz = VectorField::find(cloud, {"x", "y", "z"});
  auto normal = VectorField::find(cloud, {"normal_x", "normal_y", "normal_z"});
  if (!normal)
    normal = VectorField::find(cloud, {"nx", "ny", "nz"});
  const RigidTransform turn{transform.rotation, {0, 0, 0}};

  std::uint8_t* point = cloud.data.data.data();
  for (std::size_t i = 0; i < cloud.size(); ++i, point += cloud.data.point_step) {
    const auto p = xyz->get(point);
    if (keep_zero_returns && p == std::array<double, 3>{})
      continue;
    xyz->set(point, transform(p[0], p[1], p[2]));
    if (!normal)
      continue;
    const auto n = normal->get(point);
    normal->set(point, turn(n[0], n[1], n[2]));
  }
}

} // namespace pcl_gpu_icp::cli
