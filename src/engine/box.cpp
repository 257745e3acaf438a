#include "box.h"

#include "search/bulk.h"

#include <algorithm>
#include <limits>

namespace pcl_gpu_icp {

Box::Box(const std::vector<PlacedPoint>& points)
{
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  const search::Bulk bulk(viewOf(points));
  for (const PlacedPoint& point : points)
    if (bulk.holds(point.xyz))
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min<double>(low[axis], point.xyz[axis]);
        high[axis] = std::max<double>(high[axis], point.xyz[axis]);
      }
}

double Box::thickness() const { return std::min({high[0] - low[0], high[1] - low[1], high[2] - low[2]}); }

bool Box::holds(const std::array<double, 3>& point, double margin) const
{
  for (int axis = 0; axis < 3; ++axis)
    if (!(point[axis] >= low[axis] - margin && point[axis] <= high[axis] + margin))
      return false;
  return true;
}

} // namespace pcl_gpu_icp
