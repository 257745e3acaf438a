#include "instances/instances.h"

PCL_GPU_ICP_POINT_INSTANCES(template class, pcl::PointNormal, float)
PCL_GPU_ICP_NORMAL_INSTANCES(template class, pcl::PointNormal, float)
