#include "report/matrix.h"

#include "report/format.h"

namespace pcl_gpu_icp::report {
Matrix4 toMatrix(const RigidTransform& transform)
{
  const auto& r = transform.rotation;
  const auto& t = transform.translation;
  return {{{r[0], r[1], r[2], t[0]}, {r[3], r[4], r[5], t[1]}, {r[6], r[7], r[8], t[2]}, {0, 0, 0, 1}}};
}

std::string matrixFile(const RigidTransform& transform)
{
  std::string text;
  for (const auto& row : toMatrix(transform))
    text += format("%.17g %.17g %.17g %.17g\n", row[0], row[1], row[2], row[3]);
  return text;
}

std::string matrixText(const RigidTransform& transform)
{
  std::string text;
  for (const auto& row : toMatrix(transform))
    text += format("  %13.10f %13.10f %13.10f %16.9g\n", row[0], row[1], row[2], row[3]);
  return text;
}

} // namespace pcl_gpu_icp::report
