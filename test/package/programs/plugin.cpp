// A plugin that aligns.
#include "clouds.h"

#include <pcl_gpu_icp/icp.h>

extern "C" __attribute__((visibility("default"))) int plugin_aligns()
{
  pcl_gpu_icp::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> icp;
  icp.setInputSource(hills(shift));
  icp.setInputTarget(hills());
  return findsTheShift(icp) ? 1 : 0;
}
