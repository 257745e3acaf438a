#include "cli/kitti_scan.h"

#include "cli/input_file.h"

#include "report/format.h"

#include <cmath>
#include <cstring>

namespace pcl_gpu_icp::cli {

Cloud readKittiScan(const std::string& path, std::string_view content)
{
  Cloud cloud;
  addCoordinates(cloud, path, pcl::PCLPointField::FLOAT32);
  addField(cloud, path, "intensity", pcl::PCLPointField::FLOAT32);
  const std::size_t step = cloud.data.point_step;
  const std::string expected = "; a .bin file is read as a scan of KITTI, of 4 floats a point: x, y, z, intensity";
  if (content.size() % step != 0)
    throw inputFailure(path, report::format("its %zu bytes are no multiple of %zu", content.size(), step) + expected);
  // Rows of another length, such as nuScenes' five floats, and other types have something else there.
  for (std::size_t point = 0; point < content.size() / step; ++point) {
    float intensity = 0;
    std::memcpy(&intensity, content.data() + (point + 1) * step - sizeof intensity, sizeof intensity);
    if (!(intensity >= 0 && std::isfinite(intensity)))
      throw inputFailure(path,
                         report::format("point %zu has the intensity %g, and none is negative or not finite",
                                        point + 1,
                                        static_cast<double>(intensity)) +
                             expected);
  }
  cloud.setSize(content.size() / step, 1, path);
  cloud.data.data.assign(content.begin(), content.end());
  return cloud;
}

} // namespace pcl_gpu_icp::cli
